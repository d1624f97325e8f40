//! The monitor of the boards on a simulated machine: an emulated Cortex-M4F and the desktop compute the same bits, the log decodes, a
//! railed channel is held and flagged, a damaged outer race is named and a sound one is not.

#[path = "../target/board/src/machine.rs"]
mod machine;
#[path = "../target/board/src/run.rs"]
mod run;

use ballrace::twin::{DamageDetector, DamagedComponent};
use ballrace::{Status, Wrench};
use machine::{BLOCKS, RAILED};
use monitor::{FRAME, Frames, Monitor, SAMPLES, Verdict};
use std::io::Write;

/// Runs the monitor on the desktop.
fn run(is_damaged: bool, each: impl FnMut(&Monitor, &Frames, Option<Verdict>)) {
    run::run(is_damaged, Box::leak(Box::new(DamageDetector::new())), each).expect("the checksum of the certificate");
}

/// Returns the CRC-32 of bytes, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc)))
}

/// Checks the frames of a run: numbers, checksums, and the channels that are missing.
fn check_frames(frames: &[u8]) {
    assert_eq!(frames.len(), BLOCKS * SAMPLES * FRAME);
    for (number, frame) in (0_u32..).zip(frames.chunks(FRAME)) {
        let words: Vec<u32> =
            frame.chunks(4).map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect();
        assert_eq!((words[0], words[5]), (number, crc32(&frame[..20])), "number and checksum of frame {number}");
        let [x, y, acceleration, speed] = [1, 2, 3, 4].map(|i| f32::from_bits(words[i]));
        assert_eq!(x.is_nan(), RAILED.contains(&number), "frame {number}: {x}");
        assert!(x.is_nan() || x.abs() < 0.4e-6, "frame {number}: {x} m");
        assert!((y + 11.3e-6).abs() < 0.4e-6, "frame {number}: {y} m");
        assert!(acceleration.abs() < 300.0, "frame {number}: {acceleration} m/s^2");
        // 4090 to 4102 counts of the encoder in 40 ms.
        assert!((156.8..157.4).contains(&speed), "frame {number}: {speed} rad/s");
    }
}

/// Returns the bytes after the first line.
fn after_line(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|byte| *byte == b'\n').expect("the end of a line");
    &bytes[end + 1..]
}

#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_monitor_gives_the_same_bits_and_a_log_that_decodes() {
    let printed = super::emulated_bytes(&super::images().join("board"), super::COUNTING);
    let (mut expected, mut rest) = (vec![], &printed[..]);
    let mut logs = [vec![], vec![]];
    for (is_damaged, log) in [false, true].into_iter().zip(&mut logs) {
        run(is_damaged, |monitor, frames, verdict| {
            expected.extend_from_slice(frames);
            writeln!(expected, "{:08x} {verdict:?}", run::checksum(monitor)).expect("memory");
            let (found, after) = rest.split_at(frames.len());
            log.extend_from_slice(found);
            rest = after_line(after);
        });
    }
    logs.iter().for_each(|log| check_frames(log));
    assert!(rest.is_empty(), "{} bytes after the last block", rest.len());
    assert_eq!(printed, expected, "frames, checksums of the forces and verdicts");
}

#[test]
#[ignore = "a part of the step target of tests/run"]
fn a_railed_channel_is_held_and_flagged() {
    let mut forces: Vec<(Wrench<f32>, Status)> = vec![];
    let mut not_ok = vec![];
    run(false, |monitor, _, verdict| {
        forces.extend(monitor.forces());
        not_ok.extend(verdict.map(|verdict| verdict.not_ok));
    });
    let last_valid = forces[RAILED.start as usize - 1].0;
    assert!((last_valid.fy - 240.0).abs() < 40.0, "{last_valid:?}");
    for (number, (force, status)) in (0_u32..).zip(&forces) {
        let is_railed = RAILED.contains(&number);
        assert_eq!(*status, if is_railed { Status::INPUT_NOT_FINITE } else { Status::OK }, "sample {number}");
        assert!(!is_railed || *force == last_valid, "sample {number}: {force:?}");
    }
    assert_eq!(not_ok, [0, 300, 0], "samples of each second");
}

#[test]
#[ignore = "a part of the step target of tests/run"]
fn a_damaged_outer_race_is_named_and_a_sound_one_is_not() {
    for (is_damaged, named) in [(false, None), (true, Some(DamagedComponent::OuterRace))] {
        let mut verdicts = vec![];
        run(is_damaged, |_, _, verdict| verdicts.extend(verdict));
        let last = verdicts.last().expect("a verdict");
        assert_eq!((last.damage.named, last.damage.blocks), (named, 1), "{last:?}");
        assert!(!is_damaged || last.damage.confidence > 0.99, "{last:?}");
    }
}
