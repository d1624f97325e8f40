//! Package of the tests of the kernel on emulated microcontrollers, which are in `main.rs`.
