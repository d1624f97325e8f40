//! Live display in the terminal: state and diagnosis, orbits, spectrum, trends, loads, events, diagnoses, values and counters.

mod counters;
mod diagnoses;
mod input;
mod loads;
mod orbit;
mod spectrum;
mod trend;
mod values;

use crate::live::status::{Level, Status};
use crate::live::view::{MonitorState, SharedView, View};
use anyhow::Result;
use ballrace_twin::printable;
use ballrace_twin::scene::{Limit, Scene};
use input::Input;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{EnterAlternateScreen, size};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use ratatui::{DefaultTerminal, Frame, TerminalOptions, Viewport};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// Interval at which the display is updated. Only changed cells are sent to the terminal.
const REFRESH: Duration = Duration::from_millis(250);
/// Minimum size of the terminal: columns, rows.
const MIN_SIZE: (u16, u16) = (60, 22);
/// Largest part of the terminal that is drawn on: columns, rows. It limits the memory of the cells; a terminal can report 65535 x 65535.
const MAX_SIZE: (u16, u16) = (500, 200);

const MEASURED: Color = Color::Cyan;
const TWIN: Color = Color::Yellow;
const ALARM: Color = Color::Red;
const MUTED: Color = Color::DarkGray;

/// Display settings that keys change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct DisplaySettings {
    probe: usize,
    bearing: usize,
    indicator: usize,
    /// The panel that fills the screen; all panels are shown without one.
    panel: Option<Panel>,
    is_paused: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Panel {
    Orbits,
    Spectrum,
    Trend,
    Loads,
    Events,
    Diagnoses,
    Values,
}

/// Data that are constant during a run.
struct RunInfo<'a> {
    name: &'a str,
    source: &'a str,
    probes: Vec<String>,
    limits: &'a [Limit],
}

/// Displays `view` until the user quits, the terminal is closed, or `stop` or `failed` is set; then restores the terminal.
///
/// # Errors
/// Returns an error if the terminal cannot be set up. A terminal that is closed later is not an error.
pub fn show(scene: &Scene, source: &str, view: &SharedView, stop: &AtomicBool, failed: &AtomicBool) -> Result<()> {
    let probes = scene.recording.iter().flat_map(|r| &r.probes).map(|p| p.column.clone()).collect();
    let info = RunInfo { name: &scene.name, source, probes, limits: &scene.limits };
    let visible = visible_area(size()?);
    let mut terminal = ratatui::try_init_with_options(TerminalOptions { viewport: Viewport::Fixed(visible) })?;
    execute!(std::io::stdout(), EnterAlternateScreen)?;
    run(&mut terminal, &info, view, [stop, failed]);
    // If the terminal is closed, the destructor fails as well and would print an error.
    if terminal.show_cursor().is_err() {
        std::mem::forget(terminal);
    }
    let _ = ratatui::try_restore();
    Ok(())
}

fn run(terminal: &mut DefaultTerminal, info: &RunInfo, view: &SharedView, end_flags: [&AtomicBool; 2]) {
    let mut settings = DisplaySettings { probe: 0, bearing: 0, indicator: 0, panel: None, is_paused: false };
    let mut shown = view.get();
    let Ok(inputs) = input::start() else { return };
    while !end_flags.iter().any(|flag| flag.load(Ordering::Relaxed)) {
        if !settings.is_paused {
            shown = view.get();
        }
        let drawn =
            resize(terminal).and_then(|()| terminal.draw(|frame| draw(frame, info, &shown, settings)).map(|_| ()));
        if drawn.is_err() {
            return;
        }
        match inputs.recv_timeout(REFRESH) {
            Ok(Input::Key(key)) => {
                let interrupt = key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c');
                if interrupt || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                    return;
                }
                settings = settings.after_key(key.code, info.probes.len(), shown.snapshot.loads.len());
            }
            Ok(Input::Resized) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// Returns the part of a terminal of `columns` and `rows` that is drawn on.
fn visible_area((columns, rows): (u16, u16)) -> Rect {
    Rect::new(0, 0, columns.min(MAX_SIZE.0), rows.min(MAX_SIZE.1))
}

/// Adapts the display to the present size of the terminal.
fn resize(terminal: &mut DefaultTerminal) -> std::io::Result<()> {
    let visible = visible_area(size()?);
    if terminal.get_frame().area() == visible { Ok(()) } else { terminal.resize(visible) }
}

impl DisplaySettings {
    /// Returns the settings after a key was pressed.
    fn after_key(self, key: KeyCode, probes: usize, bearings: usize) -> Self {
        let next = |i: usize, count: usize| (i + 1) % count.max(1);
        let panel = |panel| Self { panel: if self.panel == Some(panel) { None } else { Some(panel) }, ..self };
        match key {
            KeyCode::Char('p') | KeyCode::Tab => Self { probe: next(self.probe, probes), ..self },
            KeyCode::Char('b') => Self { bearing: next(self.bearing, bearings), ..self },
            KeyCode::Char('i') => Self { indicator: next(self.indicator, trend::INDICATORS.len()), ..self },
            KeyCode::Char(' ') => Self { is_paused: !self.is_paused, ..self },
            KeyCode::Char('1') => panel(Panel::Orbits),
            KeyCode::Char('2') => panel(Panel::Spectrum),
            KeyCode::Char('3') => panel(Panel::Trend),
            KeyCode::Char('4') => panel(Panel::Loads),
            KeyCode::Char('5') => panel(Panel::Events),
            KeyCode::Char('6') => panel(Panel::Diagnoses),
            KeyCode::Char('7') => panel(Panel::Values),
            _ => self,
        }
    }
}

fn draw(frame: &mut Frame, info: &RunInfo, view: &View, settings: DisplaySettings) {
    let area = frame.area();
    if area.width < MIN_SIZE.0 || area.height < MIN_SIZE.1 {
        let (columns, rows) = MIN_SIZE;
        let message =
            format!("terminal is too small: {} x {}, expected at least {columns} x {rows}", area.width, area.height);
        return frame.render_widget(Paragraph::new(message).wrap(Wrap { trim: true }), area);
    }
    let rows = [Constraint::Length(1), Constraint::Length(HEADER_ROWS), Constraint::Min(0), Constraint::Length(1)];
    let rows = Layout::vertical(rows).split(area);
    frame.render_widget(title(info, view, settings.is_paused), rows[0]);
    frame.render_widget(state(view), rows[1]);
    frame.render_widget(key_help(), rows[3]);
    match settings.panel {
        Some(panel) => draw_panel(frame, rows[2], panel, info, view, settings),
        None => draw_overview(frame, rows[2], info, view, settings),
    }
}

fn draw_overview(frame: &mut Frame, area: Rect, info: &RunInfo, view: &View, settings: DisplaySettings) {
    let last_rows = 5;
    let half = area.height.saturating_sub(last_rows) / 2;
    let heights = [Constraint::Min(half), Constraint::Length(half), Constraint::Length(last_rows)];
    let rows = Layout::vertical(heights).split(area);
    let halves = |row: Rect| Layout::horizontal([Constraint::Percentage(50), Constraint::Percentage(50)]).split(row);
    let (upper, middle, last) = (halves(rows[0]), halves(rows[1]), halves(rows[2]));
    let mut panels = vec![(Panel::Orbits, upper[0]), (Panel::Spectrum, upper[1]), (Panel::Events, last[1])];
    if view.conclusion.is_some() {
        panels.push((Panel::Diagnoses, rows[1]));
    } else {
        let second = if view.diagnoses.is_empty() { Panel::Loads } else { Panel::Diagnoses };
        panels.extend([(Panel::Trend, middle[0]), (second, middle[1])]);
    }
    // This panel contains the values of the probes and, below them, the counters.
    panels.push((Panel::Values, last[0]));
    for (panel, area) in panels {
        draw_panel(frame, area, panel, info, view, settings);
    }
}

fn draw_panel(frame: &mut Frame, area: Rect, panel: Panel, info: &RunInfo, view: &View, settings: DisplaySettings) {
    match panel {
        Panel::Orbits => orbit::draw(frame, area, view),
        Panel::Spectrum => spectrum::draw(frame, area, info, view, settings.probe),
        Panel::Trend => trend::draw(frame, area, info, view, settings),
        Panel::Loads => loads::draw(frame, area, view, settings.bearing),
        Panel::Events => counters::draw_events(frame, area, view),
        Panel::Diagnoses => diagnoses::draw(frame, area, view),
        Panel::Values => values::draw(frame, area, view),
    }
}

/// Rows of the state: word with diagnosis on two lines, action.
const HEADER_ROWS: u16 = 3;

fn title(info: &RunInfo, view: &View, is_paused: bool) -> Paragraph<'static> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut spans = vec![
        Span::styled(format!(" {} ", info.name), bold.add_modifier(Modifier::REVERSED)),
        Span::raw(format!(" {}", info.source)),
    ];
    if view.snapshot.rate_hz > 0.0 {
        spans.push(Span::raw(format!("  {:.1} rpm  {:.1} s", view.snapshot.speed_rpm, view.snapshot.time_s)));
    }
    let state = match (is_paused, view.state) {
        (true, _) => "  display paused".to_owned(),
        (_, MonitorState::Starting) => format!("  twin starting, {:.0} s", view.pacing.starting_s),
        (_, MonitorState::Running) if view.pacing.starting_s > 0.0 => {
            format!("  twin started in {:.1} s", view.pacing.starting_s)
        }
        (_, MonitorState::Ended) => "  press q".to_owned(),
        _ => String::new(),
    };
    spans.push(Span::styled(state, Style::new().fg(MUTED)));
    Paragraph::new(Line::from(spans))
}

/// Returns the state of the machine as a coloured word, with the present alarm or diagnosis as a sentence.
fn state(view: &View) -> Paragraph<'static> {
    let status = Status::of(view);
    let colour = match status.level {
        Level::Alarm => ALARM,
        Level::Warning => Color::Yellow,
        Level::Unknown => Color::Blue,
        Level::Normal => Color::Green,
    };
    let word = Style::new().bg(colour).fg(Color::Black).add_modifier(Modifier::BOLD);
    let since = status.since.get(11..19).map_or_else(String::new, |clock| format!(" since {clock} UTC. "));
    // For an alarm, the title replaces the sentence: the panels of events and diagnoses contain the details.
    let sentence = match status.title.as_str() {
        "" => format!("{since}{} {}", status.sentence, status.action),
        title => format!("{since}{title}. {}", status.action),
    };
    let spans = vec![
        Span::styled(format!(" {} ", status.word), word),
        Span::raw(printable::lines(sentence.trim_end()).into_owned()),
    ];
    Paragraph::new(Line::from(spans)).wrap(Wrap { trim: true })
}

fn key_help() -> Paragraph<'static> {
    let keys =
        [("q", "quit"), ("p", "probe"), ("b", "bearing"), ("i", "indicator"), ("1-7", "one panel"), ("space", "pause")];
    let spans = keys.into_iter().flat_map(|(key, action)| {
        [
            Span::styled(format!(" {key} "), Style::new().add_modifier(Modifier::REVERSED)),
            Span::raw(format!(" {action}  ")),
        ]
    });
    Paragraph::new(Line::from(spans.collect::<Vec<_>>()))
}

/// Returns the border of a panel with its title.
fn panel_block(title: String) -> Block<'static> {
    Block::bordered()
        .title(Span::styled(title, Style::new().add_modifier(Modifier::BOLD)))
        .border_style(Style::new().fg(MUTED))
}

/// Draws an empty panel with a message at its centre.
fn draw_empty(frame: &mut Frame, area: Rect, block: Block<'static>, message: &str) {
    let message = Paragraph::new(message.to_owned()).style(Style::new().fg(MUTED)).centered().block(block);
    frame.render_widget(message, area);
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::live::view::Conclusion;
    use ballrace_twin::probes::planes;
    use ballrace_twin::record::{EventMessage, EventRecord};
    use ballrace_twin::replay::Snapshot;
    use ballrace_twin::replay::outcome::{
        Diagnosis, Estimate, FaultFigures, FaultForm, FaultKind, FaultParameters, MarkedLine,
    };
    use ballrace_twin::replay::second::{ProbeSecond, Second};
    use ballrace_twin::replay::snapshot::SnapshotSample;
    use ballrace_twin::scene::read::read_str;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use std::f64::consts::TAU;
    use std::path::Path;

    const DEMO: &str = include_str!("../../demo/healthy.toml");

    /// Returns the view of a running monitor.
    fn running(scene: &Scene) -> View {
        let probes = &scene.recording.as_ref().unwrap().probes;
        let angle = |i: usize| TAU * i as f64 / 256.0;
        let sample = |i: usize| SnapshotSample {
            measured: vec![
                8e-6 * angle(i).cos(),
                5e-6 * angle(i).sin(),
                3e-6 * angle(i).cos(),
                3e-6 * angle(i).sin(),
                0.0,
            ],
            twin: vec![8e-6 * angle(i).cos(), 5e-6 * angle(i).sin(), 3e-6 * angle(i).cos(), 3e-6 * angle(i).sin(), 0.0],
            passed: i.is_multiple_of(256),
        };
        let planes = planes(probes).into_iter().map(|p| (format!("plane {:.0}", p.station * 1e3), p)).collect();
        let loads = (0..9).map(|j| (TAU * f64::from(j) / 9.0, 10.0 * f64::from(j))).collect();
        let snapshot = Snapshot {
            time_s: 12.5,
            speed_rpm: 3000.0,
            rate_hz: 12_800.0,
            samples: (0..4096).map(sample).collect(),
            planes,
            loads: vec![("DE".to_owned(), loads)],
            lines: vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: 50.0 }],
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
        let message = EventMessage { kind: "source-silent", sentence: "The source sends no data.".to_owned() };
        View {
            state: MonitorState::Running,
            snapshot: snapshot.into(),
            seconds: (0..60).map(|i| second(i).into()).collect(),
            events: [EventRecord::new(message, 3.0).into()].into(),
            ..View::default()
        }
    }

    /// Returns the screen after `keys` were pressed.
    fn screen(width: u16, height: u16, view: &View, keys: &[KeyCode]) -> String {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let probes = scene.recording.iter().flat_map(|r| &r.probes).map(|p| p.column.clone()).collect();
        let info = RunInfo { name: &scene.name, source: "tcp:127.0.0.1:9000", probes, limits: &scene.limits };
        let mut settings = DisplaySettings { probe: 0, bearing: 0, indicator: 0, panel: None, is_paused: false };
        for &key in keys {
            settings = settings.after_key(key, info.probes.len(), view.snapshot.loads.len());
        }
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, &info, view, settings)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn all_panels_fit_on_80_by_24_cells() {
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
            "deadlines",
            "Events",
            "quit",
            "3000.0 rpm",
        ] {
            assert!(shown.contains(text), "missing {text} in\n{shown}");
        }
        assert!(shown.contains("The source sends no data"), "{shown}");
    }

    #[test]
    fn keys_select_probe_indicator_and_panel() {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let view = running(&scene);
        assert!(screen(80, 24, &view, &[KeyCode::Char('p')]).contains("DE_Y_um"));
        assert!(screen(80, 24, &view, &[KeyCode::Char('i')]).contains("rms"));
        let one = screen(80, 24, &view, &[KeyCode::Char('2')]);
        assert!(one.contains("Spectrum") && !one.contains("deadlines"), "{one}");
        assert!(screen(80, 24, &view, &[KeyCode::Char('2'), KeyCode::Char('2')]).contains("deadlines"));
    }

    #[test]
    fn diagnoses_are_shown_with_location_size_and_odds_during_and_after_the_run() {
        let scene = read_str(DEMO, Path::new("demo")).unwrap();
        let interval =
            |value: f64, half_width: f64| Some(Estimate { value, low: value - half_width, high: value + half_width });
        let diagnosis = Diagnosis {
            kind: FaultKind::OuterRace,
            bearing: Some("DE".to_owned()),
            failure_modes: vec![],
            line_hz: 179.2,
            order: 3.58,
            level_db: 30.0,
            confidence: 0.97,
            evidence: vec![],
            vibration: None,
            parameters: FaultParameters {
                form: Some(FaultForm::Spall),
                azimuth_deg: interval(290.0, 1.5),
                depth_um: interval(3.0, 0.2),
                odds_to_next: Some(1e12),
                ..FaultParameters::default()
            },
            sentence: String::new(),
            lines: vec![],
            figures: FaultFigures::default(),
        };
        let mut view = running(&scene);
        view.diagnoses.push(diagnosis.clone());
        view.alarms.update_faults(&view.diagnoses);
        assert!(screen(120, 24, &view, &[]).contains("Spall on the outer race, bearing DE"));
        let conclusion = Conclusion { verdict: "DE: damage of the outer race.".to_owned(), diagnoses: vec![diagnosis] };
        let view = View { conclusion: Some(conclusion), ..running(&scene) };
        for keys in [&[][..], &[KeyCode::Char('6')]] {
            let shown = screen(120, 24, &view, keys);
            for text in [
                "Spall on the outer race, bearing DE",
                "at 290.0 (288.5 to 291.5) deg from +X; depth 3.00 (2.80 to 3.20) um; odds beyond 1e6",
                "DE: damage of the outer race.",
            ] {
                assert!(shown.contains(text), "missing {text} in\n{shown}");
            }
        }
        assert!(screen(80, 24, &running(&scene), &[KeyCode::Char('6')]).contains("no fault found so far"));
    }

    #[test]
    fn missing_samples_and_a_small_terminal_are_reported() {
        assert!(screen(80, 24, &View::default(), &[]).contains("no samples yet"));
        assert!(screen(40, 10, &View::default(), &[]).contains("too small"));
        for (width, height) in [(60, 22), (200, 60), (61, 23), (300, 22)] {
            let scene = read_str(DEMO, Path::new("demo")).unwrap();
            for key in ['0', '1', '2', '3', '4', '5', '6', '7'] {
                screen(width, height, &running(&scene), &[KeyCode::Char(key)]);
            }
        }
    }
}
