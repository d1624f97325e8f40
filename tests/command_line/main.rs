//! The program as its user runs it: scenes, recordings and options in; exit code, output and files out.

mod bad_command;
mod bad_output;
mod bad_recording;
mod bad_scene;
mod bake;
mod chromium;
mod degraded;
mod equilibrium;
mod fit;
mod force;
mod formats;
mod limits;
mod live;
mod long;
mod replay;
mod scenes;
mod simulate;
mod support;
mod sweep;
mod system;
mod trade;
mod truth;
mod vibration;
