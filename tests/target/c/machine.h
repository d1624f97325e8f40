/* A rigid rotor on angular bearings, its observer, and the indicators. */
#pragma once

#include "subjects.h"

#define PROBES 4
#define LINES 4
#define ORDERS 4

extern const float start_displacement[5];
extern const ballrace_order_line order_lines[LINES];

extern ballrace_rotor rotor_on_2, rotor_on_4;
extern ballrace_observer observer;

/* Initialises rotors and observer; call `subjects_init` before. Returns the status bits of all calls. */
uint32_t machine_init(void);
