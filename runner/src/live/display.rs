//! Monitor side of the live displays: collects their data and publishes them several times per second.

use super::view::{SharedView, View};
use std::time::{Duration, Instant};

/// Interval at which the data of the live displays are updated.
const INTERVAL: Duration = Duration::from_millis(200);

/// View of a monitor, and its copy for the displays.
pub struct Display {
    /// View of the monitor.
    pub view: View,
    shared: Option<SharedView>,
    published: Option<Instant>,
}

impl Display {
    /// Creates an empty view; without a shared one it is not published.
    pub fn new(shared: Option<SharedView>) -> Self {
        Self { view: View::default(), shared, published: None }
    }

    /// Returns `true` if the next update is due.
    pub fn is_due(&self) -> bool {
        self.shared.is_some() && self.published.is_none_or(|published| published.elapsed() >= INTERVAL)
    }

    /// Returns `true` if a display has read the view since the last call.
    pub fn take_is_read(&self) -> bool {
        self.shared.as_ref().is_some_and(SharedView::take_is_read)
    }

    /// Publishes the view. If a display is reading it at this moment, the view stays due for the next block.
    pub fn publish(&mut self) {
        if let Some(shared) = &self.shared
            && shared.try_set(&self.view)
        {
            self.published = Some(Instant::now());
        }
    }
}
