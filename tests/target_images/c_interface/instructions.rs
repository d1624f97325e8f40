//! Instructions, stack and flash of the calls, in comparison with the kernel in Rust.

use super::image::{Abi, Image};
