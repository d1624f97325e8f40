//! Bounded history: when the list is full, neighbouring entries are merged.

/// Entry that can be merged with the following one.
pub(crate) trait Join {
    /// Merges `later` into this entry; `share` (0 to 1) is its share of both.
    fn join(&mut self, later: &Self, share: f64);
}

/// List of at most `most` entries. Each entry has the same number of parts, except the last.
pub struct History<T> {
    entries: Vec<T>,
    most: usize,
    /// Number of parts of a complete entry.
    span: usize,
    /// Number of parts of the last entry.
    filled: usize,
}

impl<T: Join> History<T> {
    /// Creates a history of at most `most` entries, 2 or more.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { entries: Vec::new(), most: most.max(2), span: 1, filled: 1 }
    }

    /// Adds the next part.
    pub fn push(&mut self, part: T) {
        if let Some(last) = self.entries.last_mut().filter(|_| self.filled < self.span) {
            self.filled += 1;
            last.join(&part, 1.0 / self.filled as f64);
            return;
        }
        if self.entries.len() == self.most {
            self.halve();
            return self.push(part);
        }
        self.entries.push(part);
        self.filled = 1;
    }

    /// Merges neighbours in pairs; an odd entry at the end stays half full.
    fn halve(&mut self) {
        let mut halved: Vec<T> = Vec::with_capacity(self.most);
        let odd = self.entries.len() % 2 == 1;
        for (i, entry) in self.entries.drain(..).enumerate() {
            match halved.last_mut() {
                Some(last) if i % 2 == 1 => last.join(&entry, 0.5),
                _ => halved.push(entry),
            }
        }
        self.entries = halved;
        self.filled = if odd { self.span } else { 2 * self.span };
        self.span *= 2;
    }

    /// Returns true where no entries have been merged.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.span == 1
    }

    /// Returns the entries in order.
    #[must_use]
    pub(crate) fn into_entries(self) -> Vec<T> {
        self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Join for (f64, f64) {
        fn join(&mut self, later: &Self, share: f64) {
            self.0 += share * (later.0 - self.0);
            self.1 = self.1.max(later.1);
        }
    }

    /// Means of equal shares in order, whatever the count; the greatest is kept.
    #[test]
    fn neighbours_are_joined_evenly() {
        for (most, parts) in [(8, 5), (8, 8), (8, 9), (7, 100), (48, 10_000), (2, 33)] {
            let mut history = History::new(most);
            (0..parts).for_each(|i| history.push((f64::from(i), f64::from(i))));
            assert_eq!(history.is_whole(), parts as usize <= most);
            let (span, entries) = (history.span, history.into_entries());
            assert!(entries.len() <= most && 2 * entries.len() + 2 > most.min(parts as usize), "{}", entries.len());
            for (k, (mean, greatest)) in entries.iter().enumerate() {
                let (first, end) = (k * span, ((k + 1) * span).min(parts as usize));
                assert!((mean - 0.5 * (first + end - 1) as f64).abs() < 1e-6, "{most} {parts} {k}");
                assert!((greatest - (end - 1) as f64).abs() < 1e-9);
            }
        }
    }
}
