//! Bearing models, and the properties of each that decide which keys of a scene it takes.

/// `model`, in the order of cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Model {
    /// A constant 5 x 5 stiffness.
    Linear,
    /// Separate radial and axial elements (Hajzman).
    Lumped,
    /// Closed-form variable contact angle (`docs/src/models.md#angular-contact-bearing`).
    Angular,
    /// The quasi-static model interpolated in a table, at a small fixed cost.
    Tabulated,
    /// Every ball in equilibrium between both races, solved ball by ball (`docs/src/models.md#quasi-static-bearing`).
    QuasiStatic,
    /// Elements with a mass of their own that moves along their radius (`docs/src/models.md#balls-with-mass`).
    Dynamic,
}

/// Properties of a bearing model that decide which keys of a scene it takes.
#[derive(Debug, PartialEq, Eq)]
pub struct ModelProperties {
    /// Name in a scene.
    pub name: &'static str,
    /// Values from which its forces follow.
    pub input: ModelInput,
    /// The balls are in equilibrium with `effects` of inertia and film, which may be stored in a `table`.
    pub effects: bool,
    /// Its solution takes `solver_steps`.
    pub solver_steps: bool,
    /// Its elements are coordinates of the system, with a mass of their own and `element_damping`.
    pub moving_elements: bool,
    /// `linearise` may name it.
    pub linearise: bool,
}

/// Values of a scene from which the forces of a model follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelInput {
    /// A stiffness of its own; a geometry only defines the speeds of balls and cage.
    Stiffness,
    /// A load-deflection law with radial play, which may be negative.
    Law,
    /// A geometry with a free contact angle. It carries a preload and has no interference.
    ContactAngle,
}

impl Model {
    /// All models, in the order of messages.
    pub const ALL: [Self; 6] =
        [Self::Linear, Self::Lumped, Self::Angular, Self::QuasiStatic, Self::Tabulated, Self::Dynamic];

    /// Returns the properties of the model.
    #[must_use]
    pub const fn properties(self) -> &'static ModelProperties {
        match self {
            Self::Linear => &LINEAR,
            Self::Lumped => &LUMPED,
            Self::Angular => &ANGULAR,
            Self::Tabulated => &TABULATED,
            Self::QuasiStatic => &QUASI_STATIC,
            Self::Dynamic => &DYNAMIC,
        }
    }

    /// Returns the name of the model in a scene.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.properties().name
    }

    /// Returns the model of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }

    /// Returns true for a model whose forces follow from rolling elements.
    #[must_use]
    pub fn has_elements(self) -> bool {
        self.properties().input != ModelInput::Stiffness
    }

    /// Returns true for a model with a contact angle that changes with the load.
    #[must_use]
    pub fn has_contact_angle(self) -> bool {
        self.properties().input == ModelInput::ContactAngle
    }
}

const LINEAR: ModelProperties = ModelProperties {
    name: "linear",
    input: ModelInput::Stiffness,
    effects: false,
    solver_steps: false,
    moving_elements: false,
    linearise: false,
};

const LUMPED: ModelProperties = ModelProperties {
    name: "lumped",
    input: ModelInput::Law,
    effects: false,
    solver_steps: false,
    moving_elements: false,
    linearise: true,
};

const ANGULAR: ModelProperties = ModelProperties {
    name: "angular",
    input: ModelInput::ContactAngle,
    effects: false,
    solver_steps: false,
    moving_elements: false,
    linearise: true,
};

const TABULATED: ModelProperties = ModelProperties {
    name: "tabulated",
    input: ModelInput::ContactAngle,
    effects: true,
    solver_steps: false,
    moving_elements: false,
    linearise: false,
};

const QUASI_STATIC: ModelProperties = ModelProperties {
    name: "quasi-static",
    input: ModelInput::ContactAngle,
    effects: true,
    solver_steps: true,
    moving_elements: false,
    linearise: true,
};

const DYNAMIC: ModelProperties = ModelProperties {
    name: "dynamic",
    input: ModelInput::Law,
    effects: false,
    solver_steps: false,
    moving_elements: true,
    linearise: false,
};

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
