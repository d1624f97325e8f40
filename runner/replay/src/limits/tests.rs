use super::*;

/// One limit of the peak-to-peak value at 1 um, with a duration in s.
fn monitor(duration: f64) -> LimitMonitor {
    let limit = Limit {
        indicator: Indicator::PeakToPeak,
        probe: None,
        bearing: None,
        allowed: Allowed::Most(1e-6),
        hysteresis: 0.1,
        duration,
    };
    let monitored = ProbeLimit { limit, probe: 0, line: None, max: 1e-6, present: None, largest: None, crossing: None };
    LimitMonitor {
        limits: vec![monitored],
        names: vec!["X".to_owned()],
        readings: Block::new(1),
        residuals: Block::new(1),
        events: EndedEvents::default(),
        new_events: vec![],
    }
}

/// Blocks of ten samples, 1 s each; those of `high` exceed the limit.
fn run(monitor: &mut LimitMonitor, samples: std::ops::Range<u64>, high: std::ops::Range<u64>) -> Vec<Event> {
    for index in samples {
        let size = if high.contains(&(index / 10)) { 3e-6 } else { 0.1e-6 };
        let time = index as f64 / 10.0;
        monitor.add_readings(index, time, &[if index % 2 == 0 { 0.0 } else { size }]);
        if monitor.are_readings_due(index) && index % 10 == 9 {
            monitor.close_readings(index, time, |_, _| 0.0);
        }
    }
    monitor.take_events()
}

/// An interruption of the shaft angle ends a crossing at the end of its last block, and the next block holds no sample from before.
#[test]
fn an_interruption_ends_a_crossing() {
    let mut monitor = monitor(0.0);
    let begun = run(&mut monitor, 0..55, 3..9);
    assert_eq!(begun.len(), 1, "{begun:?}");
    monitor.interrupt_readings();
    let ended = monitor.take_events();
    assert_eq!(ended.iter().map(|e| e.end_s).collect::<Vec<_>>(), [Some(4.9)]);
    // Samples 55 to 59 were high: without the interruption the next block would cross.
    assert!(run(&mut monitor, 100..120, 0..1).is_empty());
    let again = run(&mut monitor, 120..140, 12..14);
    assert_eq!(again.len(), 1, "{again:?}");
}

/// Stopped at any sample and restored from its state at that moment, the limits report what they would have reported.
#[test]
fn restored_monitor_reports_the_remaining_events() {
    for duration in [0.0, 2.0] {
        let expected = run(&mut monitor(duration), 0..100, 3..7);
        assert_eq!(expected.len(), 2, "{expected:?}");
        for stop in 0..100 {
            let mut first = monitor(duration);
            let mut events = run(&mut first, 0..stop, 3..7);
            let Some(state) = first.state() else { continue };
            let text = serde_json::to_string(&state).unwrap();
            let mut second = monitor(duration);
            second.restore(&serde_json::from_str(&text).unwrap());
            // The indicators may have to read again from farther back.
            let again = state.readings_index.unwrap().saturating_sub(7)..100;
            events.extend(run(&mut second, again, 3..7));
            let key = |e: &Event| (e.end_s.is_some(), e.start_s.round() as u64);
            let (found, wanted): (Vec<_>, Vec<_>) =
                (events.iter().map(key).collect(), expected.iter().map(key).collect());
            assert_eq!(found, wanted, "stopped at {stop}");
        }
    }
}

/// A limit that is exceeded again and again for months.
#[test]
fn the_events_of_the_report_are_the_latest() {
    let mut monitor = monitor(0.0);
    for i in 0..2 * (MAX_EVENTS + 3) {
        let value = if i % 2 == 0 { 3e-6 } else { 0.0 };
        monitor.evaluate(i as f64, i as f64 + 1.0, |_| Some(value));
        monitor.take_events();
    }
    assert!(monitor.note().unwrap().starts_with("3 exceedances"));
    let events = monitor.finish();
    assert_eq!((events.len(), events[0].start_s), (MAX_EVENTS, 6.0));
}
