//! Readings of all probes over stretches of the whole recording, in bounded memory.
//!
//! The recording is cut into pieces of a power of two of samples. While there is room every piece is kept; where there is none
//! left, every second one is dropped, and from then on only every second, fourth, ... piece is kept. What remains is spread evenly
//! over the recording.

use ballrace_outcome::{Excerpt, Stretch};
use ballrace_recording::Sample;

const UM: f64 = 1e6;
/// Readings that are kept, of the machine and its twin together.
const MAX_VALUES: usize = 300_000;
/// Longest piece: a segment of a spectrum.
const LONGEST: usize = 4096;
/// Pieces that fit at least, so that they are spread over a long recording.
const MIN_PIECES: usize = 4;
/// Shortest piece.
const SHORTEST: usize = 64;

/// Collects an excerpt.
pub(super) struct ExcerptCollector {
    rate_hz: f64,
    /// Samples in a piece.
    length: usize,
    /// Pieces that are kept at most.
    most: usize,
    /// Interval of the pieces that are kept.
    every: usize,
    /// Number of the piece that is being filled.
    number: usize,
    current: Stretch,
    /// Index of the next sample, where no gap precedes it.
    next: u64,
    kept: Vec<Piece>,
}

/// A piece that is kept.
struct Piece {
    number: usize,
    /// Index after its last sample.
    next: u64,
    stretch: Stretch,
}

impl ExcerptCollector {
    /// Creates the collector for a number of probes at a sample rate (Hz).
    pub(super) fn new(probes: usize, rate_hz: f64) -> Self {
        let fitting = MAX_VALUES / (2 * probes.max(1));
        let length = (1 << (fitting / MIN_PIECES).max(SHORTEST).ilog2()).min(LONGEST);
        Self {
            rate_hz,
            length,
            most: (fitting / length).max(1),
            every: 1,
            number: 0,
            current: empty(probes),
            next: 0,
            kept: Vec::new(),
        }
    }

    /// Adds a sample with the twin's readings; `passed` is true where the keyphasor passed since the last one.
    pub(super) fn add(&mut self, sample: &Sample, twin: &[f64], passed: bool) {
        let samples = self.current.samples();
        if samples == self.length || (samples > 0 && sample.row.index != self.next) {
            self.close();
        }
        self.next = sample.row.index + 1;
        if self.is_kept() {
            append(&mut self.current, sample.row.time, [&sample.row.probes, twin], passed);
        } else {
            self.current.count += 1;
        }
    }

    fn is_kept(&self) -> bool {
        self.number.is_multiple_of(self.every)
    }

    fn close(&mut self) {
        let probes = self.current.measured.len();
        let stretch = std::mem::replace(&mut self.current, empty(probes));
        if self.is_kept() && stretch.samples() > 0 {
            self.kept.push(Piece { number: self.number, next: self.next, stretch });
        }
        self.number += 1;
        if self.kept.len() > self.most {
            self.every *= 2;
            let every = self.every;
            self.kept.retain(|piece| piece.number.is_multiple_of(every));
        }
    }

    /// Returns the excerpt; pieces that follow each other are joined.
    pub(super) fn finish(mut self) -> Excerpt {
        self.close();
        let mut joined: Vec<Piece> = Vec::new();
        for piece in self.kept {
            match joined.last_mut() {
                Some(last) if piece.next - piece.stretch.samples() as u64 == last.next => {
                    last.next = piece.next;
                    join(&mut last.stretch, piece.stretch);
                }
                _ => joined.push(piece),
            }
        }
        Excerpt { rate_hz: self.rate_hz, stretches: joined.into_iter().map(|piece| piece.stretch).collect() }
    }
}

/// Returns a stretch without samples.
fn empty(probes: usize) -> Stretch {
    Stretch { measured: vec![Vec::new(); probes], twin: vec![Vec::new(); probes], ..Stretch::default() }
}

/// Appends a sample with the readings of recording and twin.
fn append(stretch: &mut Stretch, time_s: f64, readings: [&[f64]; 2], passed: bool) {
    if stretch.count == 0 {
        stretch.start_s = time_s;
    } else if passed {
        stretch.keyphasor.push(stretch.count);
    }
    stretch.count += 1;
    for (columns, readings) in [&mut stretch.measured, &mut stretch.twin].into_iter().zip(readings) {
        for (column, reading) in columns.iter_mut().zip(readings) {
            column.push((reading * UM) as f32);
        }
    }
}

/// Appends the stretch that follows.
fn join(stretch: &mut Stretch, next: Stretch) {
    stretch.keyphasor.extend(next.keyphasor.iter().map(|at| at + stretch.count));
    stretch.count += next.count;
    for (columns, next) in [(&mut stretch.measured, next.measured), (&mut stretch.twin, next.twin)] {
        for (column, next) in columns.iter_mut().zip(next) {
            column.extend(next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_recording::Row;

    /// Readings that are the number of the sample.
    fn collected(samples: usize, probes: usize, jump_at: usize) -> Excerpt {
        let mut collector = ExcerptCollector::new(probes, 1000.0);
        for i in 0..samples {
            let time = i as f64 * 1e-3 + if i >= jump_at { 5.0 } else { 0.0 };
            let readings = vec![i as f64 * 1e-6; probes];
            let index = i as u64 + if i >= jump_at { 5000 } else { 0 };
            let row = Row { index, time, probes: readings.clone(), ..Row::default() };
            collector.add(&Sample { row, ..Sample::default() }, &readings, i.is_multiple_of(100));
        }
        collector.finish()
    }

    fn values(excerpt: &Excerpt) -> usize {
        excerpt.stretches.iter().flat_map(|s| s.measured.iter().chain(&s.twin)).map(Vec::len).sum()
    }

    #[test]
    fn a_short_recording_is_kept_whole() {
        let excerpt = collected(10_000, 5, usize::MAX);
        assert_eq!(excerpt.stretches.len(), 1);
        let whole = &excerpt.stretches[0];
        assert_eq!((whole.samples(), whole.keyphasor.len(), whole.measured[4][9_999]), (10_000, 99, 9_999.0));
    }

    #[test]
    fn a_long_recording_is_spread_evenly_in_bounded_memory() {
        for probes in [1, 5, 40] {
            let excerpt = collected(900_000, probes, usize::MAX);
            assert!(values(&excerpt) <= MAX_VALUES, "{}", values(&excerpt));
            let last = excerpt.stretches.last().map_or(0.0, |stretch| stretch.start_s);
            assert!(excerpt.stretches.len() > 1 && last > 450.0, "{} stretches to {last} s", excerpt.stretches.len());
            for stretch in &excerpt.stretches {
                let first = stretch.measured[0][0];
                assert!((f64::from(first) * 1e-3 - stretch.start_s).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_stretch_has_no_gap() {
        let excerpt = collected(3_000, 2, 1_234);
        let lengths: Vec<usize> = excerpt.stretches.iter().map(Stretch::samples).collect();
        assert_eq!(lengths, [1_234, 1_766]);
        assert!(collected(0, 3, 0).stretches.is_empty());
    }
}
