//! Balls in a table in fixed-point arithmetic, for cores without a floating-point unit.

use crate::fixed_point::{Directions, MAX_ELEMENTS};
use crate::geometry::{InvalidParameter, check, report};
use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use crate::tabulated::{OfKernel, Tabulated};
use ballrace::Phase;
use ballrace::bearing::fixed_point::{TabulatedElements, TabulatedParams, directions};
use ballrace::blob::MIRRORED;

/// A bearing with a table, on counts.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedTabulatedParams {
    /// Speed of the ring over whose speed the table is, rad/s: the nodes are those of this speed.
    pub speed: f64,
    /// Displacement of 2^31 counts, m: the largest that the converter delivers, 2 to 100 times the distance of the groove centres.
    pub range: f64,
    /// Nodes, which belong to the bearing from its set-up on: two numbers each, with friction at the inner race three, for the nodes along approach
    /// and angle, `approach.count * angle.count` of the table.
    pub nodes: *mut i32,
    /// Number of numbers of the nodes.
    pub number_count: u32,
}

/// A bearing with a table, on counts. Opaque: `ballrace_fixed_tabulated_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct FixedTabulated {
    /// Private.
    pub words: [u64; 56],
}

type Nodes<const F: usize> = &'static mut [[i32; F]];

/// A table without or with friction at the inner race.
enum Stated {
    Plain(TabulatedElements<Directions, Nodes<2>, 2>),
    Friction(TabulatedElements<Directions, Nodes<3>, 3>),
}

impl Stored for Stated {
    const KIND: u32 = 9;
}

/// Result of the set-up: bearing, metres and newtons of a count.
type Created = Result<(Stated, [f64; 2]), ballrace::bearing::geometry::InvalidParameter>;

/// Creates a bearing with `F` numbers per node.
///
/// # Safety
/// As `ballrace_fixed_tabulated_init`, with the numbers of the model.
unsafe fn create<const F: usize>(
    (of, params): (&Tabulated, &TabulatedParams),
    (nodes, numbers): (*mut i32, u32),
    stated: impl FnOnce(TabulatedElements<Directions, Nodes<F>, F>) -> Stated,
) -> Created {
    // SAFETY: by the contract of the function.
    let (bearing, nodes): (OfKernel<'_, F>, Nodes<F>) =
        unsafe { (of.of_kernel(), core::slice::from_raw_parts_mut(nodes.cast(), numbers as usize / F)) };
    let directions = Directions::from_each(directions(&bearing, params.mirrored));
    let value = TabulatedElements::with_directions(directions, &bearing, params, nodes)?;
    let per_count = [value.metres_per_count(), value.newtons_per_count()];
    Ok((stated(value), per_count))
}

/// Initialises a bearing from the table in floats of `of`, which is not read afterwards. For set-up: uses `double`. `invalid` may be NULL. Writes what
/// a count of the displacement is in m, and a count of the force in N.
///
/// # Safety
/// `bearing`, `params` and `of`, which has one of its models, point to structs, `invalid` to a struct or nothing, `metres_per_count` and
/// `newtons_per_count` to numbers; the nodes outlive the bearing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_tabulated_init(
    bearing: *mut FixedTabulated,
    of: *const Tabulated,
    params: *const FixedTabulatedParams,
    metres_per_count: *mut f64,
    newtons_per_count: *mut f64,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(bearing, of, params, metres_per_count, newtons_per_count);
    // SAFETY: by the contract of the function.
    unsafe {
        let (of, FixedTabulatedParams { speed, range, nodes, number_count }) = (&*of, *params);
        check_pointers!(nodes);
        let elements = of.head.element_count;
        let is_held = elements as usize <= MAX_ELEMENTS;
        if check(is_held, "element_count", f64::from(elements), "at most 32", invalid) {
            return status::INVALID_ARGUMENT;
        }
        let shape = &(*of.head.model).blob;
        let params = TabulatedParams { speed, range, mirrored: shape.code & MIRRORED != 0 };
        let (from, to) = ((of, &params), (nodes, number_count));
        let created = match shape.numbers {
            2 => create::<2>(from, to, Stated::Plain),
            _ => create::<3>(from, to, Stated::Friction),
        };
        match created {
            Ok((value, per_count)) => {
                (*metres_per_count, *newtons_per_count) = per_count.into();
                state::write(bearing, value);
                status::OK
            }
            Err(error) => report(error, invalid),
        }
    }
}

/// Computes force and moment on the inner ring, `fx`, `fy`, `fz` and the moments about X and Y over the lever arm `of->arm`, at a displacement along
/// X, Y, Z and the tilts about X and Y times that arm, all in counts; any counts are valid. `BALLRACE_OUT_OF_TABLE` where a ball is outside the
/// table, `BALLRACE_CONTACT_LOST` where none carries load. Without floating-point numbers: a constant number of instructions on every core.
///
/// # Safety
/// `bearing` points to an initialised bearing; the arrays have five entries.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [wrench; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_fixed_tabulated_force(
    bearing: *const FixedTabulated,
    displacement: *const i32,
    cage_phase: u64,
    wrench: *mut i32,
) -> u32 {
    check_pointers!(bearing, displacement, wrench);
    // SAFETY: by the contract of the function.
    unsafe {
        let Some(bearing) = state::read::<Stated, _>(bearing) else {
            return status::STATE_INVALID;
        };
        let ([u, v, w, x, y], cage) = (*displacement.cast::<[i32; 5]>(), Phase(cage_phase));
        let found = match bearing {
            Stated::Plain(bearing) => bearing.reaction(u, v, w, x, y, cage),
            Stated::Friction(bearing) => bearing.reaction(u, v, w, x, y, cage),
        };
        *wrench.cast::<[i32; 5]>() = [found.fx, found.fy, found.fz, found.mx, found.my];
        u32::from(found.status.bits())
    }
}
