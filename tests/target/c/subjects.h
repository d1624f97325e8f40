/* Bearings of every model. */
#pragma once

#include "ballrace.h"

struct subject {
    const char *name;
    const ballrace_bearing *bearing;
};

#define SUBJECT_COUNT 24

extern struct subject subjects[SUBJECT_COUNT];

extern ballrace_angular angular_9;
extern const ballrace_tabulated tabulated_8, friction_9, friction_mirrored_9;

/* Initialises all bearings; returns the status bits of all calls. */
uint32_t subjects_init(void);
