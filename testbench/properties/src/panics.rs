//! Panics as values: what was said and where, and nothing of it on the terminal.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

thread_local! {
    /// A panic of this thread is caught.
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
    /// What the last one said.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs `what`, which must not be looked at again if it panics.
///
/// # Errors
/// It panics: what it said, and the file and line.
pub(crate) fn caught<T>(what: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = panic::take_hook();
        panic::set_hook(Box::new(
            move |info| {
                if CAUGHT.get() { SAID.set(said(info)) } else { others(info) }
            },
        ));
    });
    let outer = CAUGHT.replace(true);
    let done = panic::catch_unwind(AssertUnwindSafe(what));
    CAUGHT.set(outer);
    done.map_err(|_| SAID.take())
}

fn said(info: &PanicHookInfo) -> String {
    let what = info.payload_as_str().unwrap_or("a panic without words");
    info.location().map_or(what.to_string(), |at| format!("{what}, at {}:{}", at.file(), at.line()))
}
