/* The bearings of a blob in flash: `name;status;checksum;stated checksum` each, in parts as a device with a watchdog takes them. */
#include "ballrace.h"
#include "board.h"
#include <stddef.h>

__asm__(".section .rodata\n.balign 8\nblob: .incbin \"every_model.blob\"\nblob_end:\n.previous\n");
extern const uint8_t blob[], blob_end[];

static union {
    ballrace_bearing head;
    ballrace_linear linear;
    ballrace_lumped_radial radial;
    ballrace_lumped_radial_axial both;
    ballrace_angular angular;
    ballrace_tabulated table;
} of;

static void row(const char *name, const ballrace_model *model)
{
    ballrace_blob_constants constants = { .checksum = 0 };
    ballrace_checksum_state state;
    uint64_t found = 0;
    of.head.model = model;
    uint32_t status = ballrace_blob_bearing(blob, (uint32_t)(blob_end - blob), name, &of.head, &constants);
    print(name);
    print(";");
    print_number(status);
    if (status == BALLRACE_OK) {
        ballrace_checksum_begin(&state, &constants.checksum_range);
        while (ballrace_checksum_advance(&state, &of.head, 100, &found) == BALLRACE_INCOMPLETE) {
        }
    }
    print(";");
    print_hex(found);
    print(";");
    print_hex(constants.checksum);
    print("\n");
}

void run(void)
{
    ballrace_blob_check_state check = { 0, 0 };
    uint32_t status = BALLRACE_INCOMPLETE, parts = 0;
    for (; status == BALLRACE_INCOMPLETE; parts++) {
        status = ballrace_blob_check(blob, (uint32_t)(blob_end - blob), &check, 1000);
    }
    print_number(status);
    print(parts > 5 ? ";in parts\n" : ";at once\n");
    row("radial", &ballrace_lumped_radial_model);
    row("mixed", &ballrace_lumped_radial_axial_power_model);
    row("lines", &ballrace_lumped_radial_axial_line_mirrored_model);
    row("angular", &ballrace_angular_mirrored_model);
    row("springs", &ballrace_linear_model);
    row("friction", &ballrace_tabulated_friction_mirrored_model);
    row("balls", &ballrace_tabulated_model);
    row("balls", &ballrace_tabulated_mirrored_model);
    row("ball", &ballrace_tabulated_model);
}
