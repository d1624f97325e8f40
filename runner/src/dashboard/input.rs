//! Keys of the terminal, read on their own thread.
//!
//! After the other side of a terminal has closed, a read of the event library may never return: the view must not depend on
//! it. The thread ends with the program.

use ratatui::crossterm::event::{self, Event, KeyEvent, KeyEventKind};
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

/// Interval at which the terminal is checked.
const INTERVAL: Duration = Duration::from_millis(250);

/// Input from the terminal.
pub(super) enum Input {
    /// A key was pressed.
    Key(KeyEvent),
    /// The size may have changed.
    Resized,
}

/// Starts the thread. The channel closes when the terminal goes away.
///
/// # Errors
/// No thread can be started.
pub(super) fn start() -> io::Result<Receiver<Input>> {
    let (sender, receiver) = channel();
    std::thread::Builder::new().name("keys".to_owned()).spawn(move || {
        // An error is the end of the terminal: the channel closes.
        let _ = read(&sender);
    })?;
    Ok(receiver)
}

fn read(sender: &Sender<Input>) -> io::Result<()> {
    while !has_hung_up()? {
        if !event::poll(INTERVAL)? {
            continue;
        }
        let input = match event::read()? {
            Event::Key(key) if key.kind == KeyEventKind::Press => Input::Key(key),
            Event::Resize(..) => Input::Resized,
            _ => continue,
        };
        if sender.send(input).is_err() {
            break;
        }
    }
    Ok(())
}

/// Returns true where the other side of the terminal at standard input has closed.
#[cfg(unix)]
fn has_hung_up() -> io::Result<bool> {
    use nix::errno::Errno;
    use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
    use std::os::fd::AsFd;
    let stdin = io::stdin();
    let mut polled = [PollFd::new(stdin.as_fd(), PollFlags::empty())];
    match poll(&mut polled, PollTimeout::ZERO) {
        Err(Errno::EINTR) => Ok(false),
        Err(error) => Err(error.into()),
        Ok(_) => {
            Ok(polled[0].revents().is_some_and(|events| events.intersects(PollFlags::POLLHUP | PollFlags::POLLERR)))
        }
    }
}

#[cfg(not(unix))]
fn has_hung_up() -> io::Result<bool> {
    Ok(false)
}
