//! Panics as values.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

/// Runs `work` and returns its result, or the message of its panic, which is not printed.
///
/// No state that `work` changes may be used after a panic.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    thread_local! {
        static CATCHES: Cell<bool> = const { Cell::new(false) };
    }
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = take_hook();
        set_hook(Box::new(move |panic| {
            if !CATCHES.get() {
                report(panic)
            }
        }));
    });
    let outer = CATCHES.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    CATCHES.set(outer);
    result.map_err(|panic| message(panic.as_ref()))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("no message").to_owned()
}

#[cfg(test)]
#[expect(clippy::panic, reason = "panics are caught here")]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_returned_as_its_message() {
        assert_eq!(caught(|| 3), Ok(3));
        assert_eq!(caught(|| -> i32 { panic!("at {}", 7) }), Err("at 7".to_owned()));
        assert_eq!(caught(|| caught(|| -> i32 { panic!("inner") })), Ok(Err("inner".to_owned())));
    }
}
