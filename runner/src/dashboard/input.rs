//! Keyboard input, read on a thread of its own.
//!
//! A read of the event library may block forever after the terminal was closed; on its own thread it does not block the
//! display. The thread ends with the program.

use ratatui::crossterm::event::{self, Event, KeyEvent, KeyEventKind};
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

/// Interval at which the thread checks whether the terminal was closed.
const INTERVAL: Duration = Duration::from_millis(100);

/// Input from the terminal.
pub(super) enum Input {
    /// A key was pressed.
    Key(KeyEvent),
    /// The size of the terminal may have changed.
    Resized,
}

/// Starts the thread and returns its channel, which closes when the terminal is closed.
///
/// # Errors
/// Returns an error if no thread can be started.
pub(super) fn start() -> io::Result<Receiver<Input>> {
    let (sender, receiver) = channel();
    std::thread::Builder::new().name("keys".to_owned()).spawn(move || {
        // After an error the terminal cannot be used; dropping the sender closes the channel.
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

/// Returns `true` if the terminal at standard input was closed.
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
