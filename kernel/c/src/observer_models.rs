//! Observers for each number of bearings and probes. An image links only those whose constants it references.

use crate::observer::ObserverModel;

/// Observer of a rotor on 1 bearing by 1 probe.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_1_probe: ObserverModel = ObserverModel::of::<1, 1>();

/// Observer of a rotor on 1 bearing by 2 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_2_probes: ObserverModel = ObserverModel::of::<1, 2>();

/// Observer of a rotor on 1 bearing by 3 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_3_probes: ObserverModel = ObserverModel::of::<1, 3>();

/// Observer of a rotor on 1 bearing by 4 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_4_probes: ObserverModel = ObserverModel::of::<1, 4>();

/// Observer of a rotor on 1 bearing by 5 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_5_probes: ObserverModel = ObserverModel::of::<1, 5>();

/// Observer of a rotor on 1 bearing by 6 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_6_probes: ObserverModel = ObserverModel::of::<1, 6>();

/// Observer of a rotor on 1 bearing by 7 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_7_probes: ObserverModel = ObserverModel::of::<1, 7>();

/// Observer of a rotor on 1 bearing by 8 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_1_bearing_8_probes: ObserverModel = ObserverModel::of::<1, 8>();

/// Observer of a rotor on 2 bearings by 1 probe.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_1_probe: ObserverModel = ObserverModel::of::<2, 1>();

/// Observer of a rotor on 2 bearings by 2 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_2_probes: ObserverModel = ObserverModel::of::<2, 2>();

/// Observer of a rotor on 2 bearings by 3 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_3_probes: ObserverModel = ObserverModel::of::<2, 3>();

/// Observer of a rotor on 2 bearings by 4 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_4_probes: ObserverModel = ObserverModel::of::<2, 4>();

/// Observer of a rotor on 2 bearings by 5 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_5_probes: ObserverModel = ObserverModel::of::<2, 5>();

/// Observer of a rotor on 2 bearings by 6 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_6_probes: ObserverModel = ObserverModel::of::<2, 6>();

/// Observer of a rotor on 2 bearings by 7 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_7_probes: ObserverModel = ObserverModel::of::<2, 7>();

/// Observer of a rotor on 2 bearings by 8 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_2_bearings_8_probes: ObserverModel = ObserverModel::of::<2, 8>();

/// Observer of a rotor on 3 bearings by 1 probe.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_1_probe: ObserverModel = ObserverModel::of::<3, 1>();

/// Observer of a rotor on 3 bearings by 2 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_2_probes: ObserverModel = ObserverModel::of::<3, 2>();

/// Observer of a rotor on 3 bearings by 3 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_3_probes: ObserverModel = ObserverModel::of::<3, 3>();

/// Observer of a rotor on 3 bearings by 4 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_4_probes: ObserverModel = ObserverModel::of::<3, 4>();

/// Observer of a rotor on 3 bearings by 5 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_5_probes: ObserverModel = ObserverModel::of::<3, 5>();

/// Observer of a rotor on 3 bearings by 6 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_6_probes: ObserverModel = ObserverModel::of::<3, 6>();

/// Observer of a rotor on 3 bearings by 7 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_7_probes: ObserverModel = ObserverModel::of::<3, 7>();

/// Observer of a rotor on 3 bearings by 8 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_3_bearings_8_probes: ObserverModel = ObserverModel::of::<3, 8>();

/// Observer of a rotor on 4 bearings by 1 probe.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_1_probe: ObserverModel = ObserverModel::of::<4, 1>();

/// Observer of a rotor on 4 bearings by 2 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_2_probes: ObserverModel = ObserverModel::of::<4, 2>();

/// Observer of a rotor on 4 bearings by 3 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_3_probes: ObserverModel = ObserverModel::of::<4, 3>();

/// Observer of a rotor on 4 bearings by 4 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_4_probes: ObserverModel = ObserverModel::of::<4, 4>();

/// Observer of a rotor on 4 bearings by 5 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_5_probes: ObserverModel = ObserverModel::of::<4, 5>();

/// Observer of a rotor on 4 bearings by 6 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_6_probes: ObserverModel = ObserverModel::of::<4, 6>();

/// Observer of a rotor on 4 bearings by 7 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_7_probes: ObserverModel = ObserverModel::of::<4, 7>();

/// Observer of a rotor on 4 bearings by 8 probes.
#[unsafe(no_mangle)]
pub static ballrace_observer_of_4_bearings_8_probes: ObserverModel = ObserverModel::of::<4, 8>();
