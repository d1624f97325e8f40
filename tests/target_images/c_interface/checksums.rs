//! The C library computes the bits of the kernel.

use super::image::{Abi, Image};

/// Every call on the emulated Cortex-M4F with both float ABIs: the kernel called directly on the desktop gives the same
/// bits.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and two targets; tests/run runs it"]
fn firmware_of_c_gives_the_bits_of_the_desktop() {
    let expected = super::expected::lines();
    for abi in [Abi::Hard, Abi::Soft] {
        let image = Image::new(abi)
            .sources(&["checksums.c", "blocks.c", "inputs.c", "subjects.c", "machine.c"])
            .link("checksums");
        let found = image.run();
        for (found, expected) in found.lines().zip(expected.lines()) {
            assert_eq!(found, expected, "{abi:?}");
        }
        assert_eq!(found.lines().count(), expected.lines().count(), "{found}");
    }
}
