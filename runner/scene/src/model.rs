//! Bearing models, and the properties of each that decide which keys of a scene it takes.
//!
//! A new model is a new row of [`models!`].

use super::key::{Key, Kind, NOT_NEGATIVE, key};
use super::multibody;
use super::units::Dimension;

/// Defines [`Model`] from a row of properties for each model, in the order of messages.
macro_rules! models {
    ($($(#[$doc:meta])* $model:ident: $properties:expr,)+) => {
        /// `model`
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Model {
            $($(#[$doc])* $model,)+
        }

        impl Model {
            /// All models, in the order of messages.
            pub const ALL: [Self; [$(Self::$model),+].len()] = [$(Self::$model),+];

            /// Returns the properties of the model.
            #[must_use]
            pub const fn properties(self) -> &'static ModelProperties {
                match self {
                    $(Self::$model => const { &$properties },)+
                }
            }
        }

        /// Keys of each model that only this model takes.
        pub(crate) static OWN_KEYS: [&[Key]; Model::ALL.len()] = [$(Model::$model.properties().own_keys),+];
    };
}

/// Values that a row does not give.
const NO_KEYS: ModelProperties = ModelProperties {
    name: "",
    cost: 0,
    input: ModelInput::Stiffness,
    effects: false,
    solver_steps: false,
    moving_elements: false,
    bodies: false,
    linearise: false,
    inclined_rollers: false,
    own_keys: &[],
};

models! {
    /// Orders without forces: a bearing without `model`, for vibration sensors alone.
    Kinematics: ModelProperties { name: "kinematics", input: ModelInput::Orders, ..NO_KEYS },
    /// A constant 5 x 5 stiffness.
    Linear: ModelProperties { name: "linear", cost: 0, ..NO_KEYS },
    /// Separate radial and axial elements (Hajzman).
    Lumped: ModelProperties { name: "lumped", cost: 1, input: ModelInput::Law, linearise: true, ..NO_KEYS },
    /// Closed-form variable contact angle (`docs/src/models.md#angular-contact-bearing`).
    Angular: ModelProperties { name: "angular", cost: 2, input: ModelInput::ContactAngle, linearise: true, ..NO_KEYS },
    /// Rollers by laminae, both contacts in series (`docs/src/models.md#rollers-by-laminae`).
    Roller: ModelProperties {
        name: "roller",
        cost: 3,
        input: ModelInput::Rollers,
        linearise: true,
        inclined_rollers: true,
        ..NO_KEYS
    },
    /// Every roller in equilibrium between both races (`docs/src/models.md#rollers-in-equilibrium`). `quasi-static` with
    /// `roller_diameter` is this model.
    QuasiStaticRoller: ModelProperties {
        name: "quasi-static-roller",
        cost: 6,
        input: ModelInput::Rollers,
        linearise: true,
        ..NO_KEYS
    },
    /// Every ball in equilibrium between both races, solved ball by ball (`docs/src/models.md#quasi-static-bearing`).
    QuasiStatic: ModelProperties {
        name: "quasi-static",
        cost: 5,
        input: ModelInput::ContactAngle,
        effects: true,
        solver_steps: true,
        linearise: true,
        own_keys: &[key(
            "solver_steps",
            Kind::Integer(1, 50),
            "Newton steps from a cold start",
            "8",
            "only `quasi-static`",
            "12",
        )],
        ..NO_KEYS
    },
    /// The quasi-static model interpolated in a table, at a small fixed cost.
    Tabulated: ModelProperties {
        name: "tabulated",
        cost: 4,
        input: ModelInput::ContactAngle,
        effects: true,
        ..NO_KEYS
    },
    /// Elements with a mass of their own that moves along their radius (`docs/src/models.md#balls-with-mass`).
    Dynamic: ModelProperties {
        name: "dynamic",
        cost: 7,
        input: ModelInput::Law,
        moving_elements: true,
        own_keys: &[key(
            "element_damping",
            Kind::Quantity(Dimension::Damping, NOT_NEGATIVE),
            "damping of each ball along its radius",
            "0",
            "only `dynamic`",
            "50",
        )],
        ..NO_KEYS
    },
    /// Balls and cage as bodies with six degrees of freedom, with traction (`docs/src/models.md#balls-and-cage-as-bodies`).
    Multibody: ModelProperties {
        name: "multibody",
        cost: 8,
        input: ModelInput::ContactAngle,
        moving_elements: true,
        bodies: true,
        own_keys: &multibody::KEYS,
        ..NO_KEYS
    },
}

/// Properties of a bearing model that decide which keys of a scene it takes.
#[derive(Debug)]
pub struct ModelProperties {
    /// Name in a scene.
    pub name: &'static str,
    /// Place in the order of cost.
    pub cost: u8,
    /// Values from which its forces follow.
    pub input: ModelInput,
    /// The balls are in equilibrium with `effects` of inertia and film, which may be stored in a `table`.
    pub effects: bool,
    /// Its solution takes `solver_steps`.
    pub solver_steps: bool,
    /// Its elements move by themselves, with a mass of their own.
    pub moving_elements: bool,
    /// Balls and cage are bodies beside the coordinates of the system.
    pub bodies: bool,
    /// `linearise` may name it.
    pub linearise: bool,
    /// It takes tapered and spherical rollers.
    pub inclined_rollers: bool,
    /// Keys of numbers that only this model takes. [`Bearing::own`](super::Bearing::own) returns their values.
    pub(crate) own_keys: &'static [Key],
}

/// Values of a scene from which the forces of a model follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelInput {
    /// None: it has no forces.
    Orders,
    /// A stiffness of its own; a geometry only defines the speeds of balls and cage.
    Stiffness,
    /// A load-deflection law with radial play, which may be negative.
    Law,
    /// A geometry with a free contact angle. It carries a preload and has no interference.
    ContactAngle,
    /// Rollers with a geometry, and their radial play, which may be negative.
    Rollers,
}

impl Model {
    /// Returns the name of the model in a scene.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.properties().name
    }

    /// Returns the names of the keys that only this model takes.
    pub fn own_keys(self) -> impl Iterator<Item = &'static str> {
        self.properties().own_keys.iter().map(|key| key.name)
    }

    /// Returns the model of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }

    /// Returns true for a model whose forces follow from rolling elements.
    #[must_use]
    pub fn has_elements(self) -> bool {
        matches!(self.properties().input, ModelInput::Law | ModelInput::ContactAngle | ModelInput::Rollers)
    }

    /// Returns the model for a bearing with rollers: each model of elements in equilibrium has one for balls and one for rollers.
    #[must_use]
    pub fn for_rollers(self) -> Self {
        if self == Self::QuasiStatic { Self::QuasiStaticRoller } else { self }
    }

    /// Returns true for a model with forces, which a scene may name.
    #[must_use]
    pub fn has_forces(self) -> bool {
        self.properties().input != ModelInput::Orders
    }

    /// Returns the models with forces.
    pub fn with_forces() -> impl DoubleEndedIterator<Item = Self> {
        Self::ALL.into_iter().filter(|model| model.has_forces())
    }

    /// Returns true for a model with a contact angle that changes with the load.
    #[must_use]
    pub fn has_contact_angle(self) -> bool {
        self.properties().input == ModelInput::ContactAngle
    }
}

/// Returns the names of models as a choice, such as `"quasi-static" or "tabulated"`.
pub(crate) fn choice_of(models: impl IntoIterator<Item = Model>) -> String {
    let names: Vec<String> = models.into_iter().map(|model| format!("\"{}\"", model.name())).collect();
    match names.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => names.concat(),
    }
}

/// Returns the models whose properties pass `has`.
pub(crate) fn models_with(has: impl Fn(&ModelProperties) -> bool) -> impl DoubleEndedIterator<Item = Model> {
    Model::ALL.into_iter().filter(move |model| has(model.properties()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_model_has_a_name_of_its_own() {
        for model in Model::ALL {
            assert_eq!(Model::from_name(model.name()), Some(model));
        }
        assert_eq!(choice_of(models_with(|of| of.effects)), "\"quasi-static\" or \"tabulated\"");
        assert_eq!(choice_of([Model::Linear]), "\"linear\"");
    }
}
