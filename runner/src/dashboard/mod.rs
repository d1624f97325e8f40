//! The live view in the terminal: orbits, spectrum, trends, loads, the ledger, the events and the findings.

mod findings;
mod input;
mod ledger;
mod loads;
mod orbit;
mod spectrum;
mod trend;

use crate::live::source::lock;
use crate::live::view::{Shared, View};
use anyhow::Result;
use ballrace_twin::scene::{Limit, Scene};
use input::Input;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};
use ratatui::{DefaultTerminal, Frame};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// From one picture to the next. Only cells that changed are sent.
const REFRESH: Duration = Duration::from_millis(250);
/// Narrower or lower than this there is no room.
const SMALLEST: (u16, u16) = (60, 20);

const MEASURED: Color = Color::Cyan;
const TWIN: Color = Color::Yellow;
const ALARM: Color = Color::Red;
const QUIET: Color = Color::DarkGray;

/// Settings chosen by keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Choice {
    probe: usize,
    bearing: usize,
    indicator: usize,
    /// One panel over the whole screen.
    panel: Option<Panel>,
    held: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Panel {
    Orbits,
    Spectrum,
    Trend,
    Loads,
    Events,
    Findings,
}

/// Data that are constant during a run.
struct Machine<'a> {
    name: &'a str,
    source: &'a str,
    probes: Vec<String>,
    limits: &'a [Limit],
}

/// Shows `view` until a key, the end of the terminal, `stop` or `over` ends it; the terminal is then as it was.
///
/// # Errors
/// A terminal that cannot be set up. One that goes away later ends the view without an error.
pub fn show(scene: &Scene, source: &str, view: &Shared, stop: &AtomicBool, over: &AtomicBool) -> Result<()> {
    let probes = scene.recording.iter().flat_map(|r| &r.probes).map(|p| p.column.clone()).collect();
    let machine = Machine { name: &scene.name, source, probes, limits: &scene.limits };
    let mut terminal = ratatui::try_init()?;
    run(&mut terminal, &machine, view, [stop, over]);
    // There may be no terminal left to restore, nor one on which the drop could report that.
    if terminal.show_cursor().is_err() {
        std::mem::forget(terminal);
    }
    let _ = ratatui::try_restore();
    Ok(())
}

fn run(terminal: &mut DefaultTerminal, machine: &Machine, view: &Shared, ends: [&AtomicBool; 2]) {
    let mut choice = Choice { probe: 0, bearing: 0, indicator: 0, panel: None, held: false };
    let mut seen = View::default();
    let Ok(inputs) = input::start() else { return };
    while !ends.iter().any(|end| end.load(Ordering::Relaxed)) {
        if !choice.held {
            seen = lock(view).clone();
        }
        if terminal.draw(|frame| draw(frame, machine, &seen, choice)).is_err() {
            return;
        }
        match inputs.recv_timeout(REFRESH) {
            Ok(Input::Key(key)) => {
                let interrupt = key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c');
                if interrupt || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                    return;
                }
                choice = choice.after(key.code, machine.probes.len(), seen.glance.loads.len());
            }
            Ok(Input::Resized) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

impl Choice {
    fn after(self, key: KeyCode, probes: usize, bearings: usize) -> Self {
        let next = |i: usize, count: usize| (i + 1) % count.max(1);
        let panel = |panel| Self { panel: if self.panel == Some(panel) { None } else { Some(panel) }, ..self };
        match key {
            KeyCode::Char('p') | KeyCode::Tab => Self { probe: next(self.probe, probes), ..self },
            KeyCode::Char('b') => Self { bearing: next(self.bearing, bearings), ..self },
            KeyCode::Char('i') => Self { indicator: next(self.indicator, trend::INDICATORS.len()), ..self },
            KeyCode::Char(' ') => Self { held: !self.held, ..self },
            KeyCode::Char('1') => panel(Panel::Orbits),
            KeyCode::Char('2') => panel(Panel::Spectrum),
            KeyCode::Char('3') => panel(Panel::Trend),
            KeyCode::Char('4') => panel(Panel::Loads),
            KeyCode::Char('5') => panel(Panel::Events),
            KeyCode::Char('6') => panel(Panel::Findings),
            _ => self,
        }
    }
}

fn draw(frame: &mut Frame, machine: &Machine, view: &View, choice: Choice) {
    let area = frame.area();
    if area.width < SMALLEST.0 || area.height < SMALLEST.1 {
        let message =
            format!("{} x {} is too small: {} x {} or more, please.", area.width, area.height, SMALLEST.0, SMALLEST.1);
        return frame.render_widget(Paragraph::new(message), area);
    }
    let rows = Layout::vertical([Constraint::Length(1), Constraint::Min(0), Constraint::Length(1)]).split(area);
    frame.render_widget(header(machine, view, choice.held), rows[0]);
    frame.render_widget(keys(), rows[2]);
    match choice.panel {
        Some(panel) => one(frame, rows[1], panel, machine, view, choice),
        None => overview(frame, rows[1], machine, view, choice),
    }
}

fn overview(frame: &mut Frame, area: Rect, machine: &Machine, view: &View, choice: Choice) {
    let lower = 5;
    let half = area.height.saturating_sub(lower) / 2;
    let heights = [Constraint::Min(half), Constraint::Length(half), Constraint::Length(lower)];
    let rows = Layout::vertical(heights).split(area);
    let halves = |row: Rect| Layout::horizontal([Constraint::Percentage(50), Constraint::Percentage(50)]).split(row);
    let (upper, middle, last) = (halves(rows[0]), halves(rows[1]), halves(rows[2]));
    let mut places = vec![(Panel::Orbits, upper[0]), (Panel::Spectrum, upper[1]), (Panel::Events, last[1])];
    if view.conclusion.is_some() {
        places.push((Panel::Findings, rows[1]));
    } else {
        let second = if view.glance.findings.is_empty() { Panel::Loads } else { Panel::Findings };
        places.extend([(Panel::Trend, middle[0]), (second, middle[1])]);
    }
    for (panel, place) in places {
        one(frame, place, panel, machine, view, choice);
    }
    ledger::draw(frame, last[0], view);
}

fn one(frame: &mut Frame, area: Rect, panel: Panel, machine: &Machine, view: &View, choice: Choice) {
    match panel {
        Panel::Orbits => orbit::draw(frame, area, view),
        Panel::Spectrum => spectrum::draw(frame, area, machine, view, choice.probe),
        Panel::Trend => trend::draw(frame, area, machine, view, choice),
        Panel::Loads => loads::draw(frame, area, view, choice.bearing),
        Panel::Events => ledger::events(frame, area, view),
        Panel::Findings => findings::draw(frame, area, view),
    }
}

fn header(machine: &Machine, view: &View, held: bool) -> Paragraph<'static> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let state = if held { "display paused" } else { view.state };
    let alarm = view.state.contains("silent") || held;
    let mut spans = vec![
        Span::styled(format!(" {} ", machine.name), bold.add_modifier(Modifier::REVERSED)),
        Span::raw(format!(" {}  ", machine.source)),
        Span::styled(state.to_owned(), if alarm { bold.fg(ALARM) } else { bold.fg(Color::Green) }),
    ];
    if view.glance.rate_hz > 0.0 {
        spans.push(Span::raw(format!("  {:.1} rpm  {:.1} s", view.glance.speed_rpm, view.glance.time_s)));
    }
    Paragraph::new(Line::from(spans))
}

fn keys() -> Paragraph<'static> {
    let keys =
        [("q", "quit"), ("p", "probe"), ("b", "bearing"), ("i", "indicator"), ("1-6", "one panel"), ("space", "hold")];
    let spans = keys.into_iter().flat_map(|(key, does)| {
        [
            Span::styled(format!(" {key} "), Style::new().add_modifier(Modifier::REVERSED)),
            Span::raw(format!(" {does}  ")),
        ]
    });
    Paragraph::new(Line::from(spans.collect::<Vec<_>>()))
}

/// The frame of a panel.
fn panel(title: String) -> Block<'static> {
    Block::bordered()
        .title(Span::styled(title, Style::new().add_modifier(Modifier::BOLD)))
        .border_style(Style::new().fg(QUIET))
}

/// Writes a message in the middle of an empty panel.
fn empty(frame: &mut Frame, area: Rect, block: Block<'static>, why: &str) {
    let message = Paragraph::new(why.to_owned()).style(Style::new().fg(QUIET)).centered().block(block);
    frame.render_widget(message, area);
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::live::out::EventRecord;
    use crate::live::view::Conclusion;
    use ballrace_twin::probes::planes;
    use ballrace_twin::replay::Snapshot;
    use ballrace_twin::replay::outcome::{
        Estimate, FaultFigures, FaultForm, FaultParameters, Finding, FindingKind, MarkedLine,
    };
    use ballrace_twin::replay::second::{ProbeSecond, Second};
    use ballrace_twin::replay::snapshot::SnapshotSample;
    use ballrace_twin::scene::read::read_str;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use std::f64::consts::TAU;
    use std::path::Path;

    const DEMO: &str = include_str!("../../demo/healthy.toml");

    fn running(scene: &Scene) -> View {
        let probes = &scene.recording.as_ref().unwrap().probes;
        let turn = |i: usize| TAU * i as f64 / 256.0;
        let sample = |i: usize| SnapshotSample {
            measured: vec![8e-6 * turn(i).cos(), 5e-6 * turn(i).sin(), 3e-6 * turn(i).cos(), 3e-6 * turn(i).sin(), 0.0],
            twin: vec![8e-6 * turn(i).cos(), 5e-6 * turn(i).sin(), 3e-6 * turn(i).cos(), 3e-6 * turn(i).sin(), 0.0],
            passed: i.is_multiple_of(256),
        };
        let planes = planes(probes).into_iter().map(|p| (format!("plane {:.0}", p.station * 1e3), p)).collect();
        let loads = (0..9).map(|j| (TAU * f64::from(j) / 9.0, 10.0 * f64::from(j))).collect();
        let glance = Snapshot {
            time_s: 12.5,
            speed_rpm: 3000.0,
            rate_hz: 12_800.0,
            samples: (0..4096).map(sample).collect(),
            planes,
            loads: vec![("DE".to_owned(), loads)],
            lines: vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: 50.0 }],
            findings: vec![],
        };
        let second = |i: i32| Second {
            time_s: f64::from(i),
            probes: probes
                .iter()
                .map(|p| ProbeSecond {
                    name: p.column.clone(),
                    peak_to_peak_um: 10.0 + f64::from(i % 3),
                    ..ProbeSecond::default()
                })
                .collect(),
            ..Second::default()
        };
        let note = crate::live::feed::Note { kind: "source-silent", sentence: "The source sends no data.".to_owned() };
        View {
            state: "running",
            glance,
            seconds: (0..60).map(second).collect(),
            events: [EventRecord::note(note, 3.0)].into(),
            ..View::default()
        }
    }

    fn screen(width: u16, height: u16, view: &View, keys: &[KeyCode]) -> String {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let probes = scene.recording.iter().flat_map(|r| &r.probes).map(|p| p.column.clone()).collect();
        let machine = Machine { name: &scene.name, source: "tcp:127.0.0.1:9000", probes, limits: &scene.limits };
        let mut choice = Choice { probe: 0, bearing: 0, indicator: 0, panel: None, held: false };
        for &key in keys {
            choice = choice.after(key, machine.probes.len(), view.glance.loads.len());
        }
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, &machine, view, choice)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn everything_fits_on_80_by_24() {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let shown = screen(80, 24, &running(&scene), &[]);
        for text in [
            "plane -120",
            "um pp",
            "Spectrum",
            "1X",
            "peak-to-peak",
            "Loads",
            "DE",
            "Deadlines",
            "Events",
            "quit",
            "3000.0 rpm",
        ] {
            assert!(shown.contains(text), "{text} is not on\n{shown}");
        }
        assert!(shown.contains("The source sends no data"), "{shown}");
    }

    #[test]
    fn keys_choose_probe_indicator_and_panel() {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let view = running(&scene);
        assert!(screen(80, 24, &view, &[KeyCode::Char('p')]).contains("DE_Y_um"));
        assert!(screen(80, 24, &view, &[KeyCode::Char('i')]).contains("rms"));
        let one = screen(80, 24, &view, &[KeyCode::Char('2')]);
        assert!(one.contains("Spectrum") && !one.contains("Deadlines"), "{one}");
        assert!(screen(80, 24, &view, &[KeyCode::Char('2'), KeyCode::Char('2')]).contains("Deadlines"));
    }

    #[test]
    fn findings_come_with_place_size_and_odds_in_the_run_and_at_its_end() {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let around = |value: f64, half: f64| Some(Estimate { value, low: value - half, high: value + half });
        let finding = Finding {
            kind: FindingKind::OuterRace,
            bearing: Some("DE".to_owned()),
            line_hz: 179.2,
            order: 3.58,
            level_db: 30.0,
            confidence: 0.97,
            parameters: FaultParameters {
                form: Some(FaultForm::Spall),
                azimuth_deg: around(290.0, 1.5),
                depth_um: around(3.0, 0.2),
                odds_to_next: Some(1e12),
                ..FaultParameters::default()
            },
            sentence: String::new(),
            figures: FaultFigures::default(),
        };
        let mut view = running(&scene);
        view.glance.findings.push(finding.clone());
        assert!(screen(120, 24, &view, &[]).contains("Spall on the outer race, bearing DE"));
        let conclusion = Conclusion { verdict: "DE: damage of the outer race.".to_owned(), findings: vec![finding] };
        let view = View { conclusion: Some(conclusion), ..running(&scene) };
        for keys in [&[][..], &[KeyCode::Char('6')]] {
            let shown = screen(120, 24, &view, keys);
            for text in [
                "Spall on the outer race, bearing DE",
                "at 290.0 (288.5 to 291.5) deg from +X; depth 3.00 (2.80 to 3.20) um; odds beyond 1e6",
                "DE: damage of the outer race.",
            ] {
                assert!(shown.contains(text), "{text} is not on\n{shown}");
            }
        }
        assert!(screen(80, 24, &running(&scene), &[KeyCode::Char('6')]).contains("no fault is found so far"));
    }

    #[test]
    fn nothing_yet_and_no_room_are_said() {
        assert!(screen(80, 24, &View::default(), &[]).contains("no samples yet"));
        assert!(screen(40, 10, &View::default(), &[]).contains("too small"));
        for (width, height) in [(60, 20), (200, 60), (61, 21), (300, 20)] {
            let scene = read_str(DEMO, Path::new("demo")).unwrap();
            for key in ['0', '1', '2', '3', '4', '5', '6'] {
                screen(width, height, &running(&scene), &[KeyCode::Char(key)]);
            }
        }
    }
}
