//! Which functions of the standard a library has to export.

use steerguard_fmi2::Function;
use steerguard_fmi3::Function as Function3;
use steerguard_model_description::xml::{Implementation, InterfaceType};

/// Functions of FMI 2.0 for Co-Simulation alone.
const CO_SIMULATION: [Function; 9] = [
    Function::fmi2SetRealInputDerivatives,
    Function::fmi2GetRealOutputDerivatives,
    Function::fmi2DoStep,
    Function::fmi2CancelStep,
    Function::fmi2GetStatus,
    Function::fmi2GetRealStatus,
    Function::fmi2GetIntegerStatus,
    Function::fmi2GetBooleanStatus,
    Function::fmi2GetStringStatus,
];

/// Functions of FMI 2.0 for Model Exchange alone.
const MODEL_EXCHANGE: [Function; 10] = [
    Function::fmi2EnterEventMode,
    Function::fmi2NewDiscreteStates,
    Function::fmi2EnterContinuousTimeMode,
    Function::fmi2CompletedIntegratorStep,
    Function::fmi2SetTime,
    Function::fmi2SetContinuousStates,
    Function::fmi2GetDerivatives,
    Function::fmi2GetEventIndicators,
    Function::fmi2GetContinuousStates,
    Function::fmi2GetNominalsOfContinuousStates,
];

/// Functions that importers do without unless a flag of the description is set.
const OPTIONAL: [(Function, &str); 7] = [
    (Function::fmi2GetFMUstate, "canGetAndSetFMUstate"),
    (Function::fmi2SetFMUstate, "canGetAndSetFMUstate"),
    (Function::fmi2FreeFMUstate, "canGetAndSetFMUstate"),
    (Function::fmi2SerializedFMUstateSize, "canSerializeFMUstate"),
    (Function::fmi2SerializeFMUstate, "canSerializeFMUstate"),
    (Function::fmi2DeSerializeFMUstate, "canSerializeFMUstate"),
    (Function::fmi2GetDirectionalDerivative, "providesDirectionalDerivative"),
];

/// Functions of FMI 3.0 for one interface type alone.
const INTERFACES_OF_3: [(Function3, InterfaceType); 17] = {
    use InterfaceType::{CoSimulation, ModelExchange, ScheduledExecution};
    [
        (Function3::fmi3InstantiateCoSimulation, CoSimulation),
        (Function3::fmi3EnterStepMode, CoSimulation),
        (Function3::fmi3GetOutputDerivatives, CoSimulation),
        (Function3::fmi3DoStep, CoSimulation),
        (Function3::fmi3InstantiateModelExchange, ModelExchange),
        (Function3::fmi3EnterContinuousTimeMode, ModelExchange),
        (Function3::fmi3CompletedIntegratorStep, ModelExchange),
        (Function3::fmi3SetTime, ModelExchange),
        (Function3::fmi3SetContinuousStates, ModelExchange),
        (Function3::fmi3GetContinuousStateDerivatives, ModelExchange),
        (Function3::fmi3GetEventIndicators, ModelExchange),
        (Function3::fmi3GetContinuousStates, ModelExchange),
        (Function3::fmi3GetNominalsOfContinuousStates, ModelExchange),
        (Function3::fmi3GetNumberOfEventIndicators, ModelExchange),
        (Function3::fmi3GetNumberOfContinuousStates, ModelExchange),
        (Function3::fmi3InstantiateScheduledExecution, ScheduledExecution),
        (Function3::fmi3ActivateModelPartition, ScheduledExecution),
    ]
};

/// Functions of FMI 3.0 that importers do without unless a flag of the description is set.
const OPTIONAL_OF_3: [(Function3, &str); 11] = [
    (Function3::fmi3GetFMUState, "canGetAndSetFMUState"),
    (Function3::fmi3SetFMUState, "canGetAndSetFMUState"),
    (Function3::fmi3FreeFMUState, "canGetAndSetFMUState"),
    (Function3::fmi3SerializedFMUStateSize, "canSerializeFMUState"),
    (Function3::fmi3SerializeFMUState, "canSerializeFMUState"),
    (Function3::fmi3DeserializeFMUState, "canSerializeFMUState"),
    (Function3::fmi3GetDirectionalDerivative, "providesDirectionalDerivatives"),
    (Function3::fmi3GetAdjointDerivative, "providesAdjointDerivatives"),
    (Function3::fmi3GetNumberOfVariableDependencies, "providesPerElementDependencies"),
    (Function3::fmi3GetVariableDependencies, "providesPerElementDependencies"),
    (Function3::fmi3EvaluateDiscreteStates, "providesEvaluateDiscreteStates"),
];

/// A function that is looked for.
pub(super) struct Wanted {
    pub(super) name: &'static str,
    /// Importers do without it: the flag that would announce it is not set.
    pub(super) dispensable: bool,
}

/// What a library that serves these implementations has to export, in FMI 3.0 or else 2.0.
pub(super) fn wanted(is_version_3: bool, served: &[&Implementation]) -> Vec<Wanted> {
    let serves = |interface| served.iter().any(|i| i.interface == interface);
    let unannounced = |flag: Option<&str>| {
        flag.is_some_and(|flag| !served.iter().any(|i| i.flags.iter().any(|f| f == flag)))
    };
    if is_version_3 {
        let interface = |function| INTERFACES_OF_3.iter().find(|(of, _)| *of == function);
        let flag = |function| OPTIONAL_OF_3.iter().find(|(of, _)| *of == function);
        return Function3::ALL
            .iter()
            .filter(|&&function| interface(function).is_none_or(|(_, of)| serves(*of)))
            .map(|&function| Wanted {
                name: function.name(),
                dispensable: unannounced(flag(function).map(|(_, flag)| *flag)),
            })
            .collect();
    }
    let flag = |function| OPTIONAL.iter().find(|(of, _)| *of == function);
    Function::ALL
        .iter()
        .filter(|f| serves(InterfaceType::CoSimulation) || !CO_SIMULATION.contains(f))
        .filter(|f| serves(InterfaceType::ModelExchange) || !MODEL_EXCHANGE.contains(f))
        .map(|&function| Wanted {
            name: function.name(),
            dispensable: unannounced(flag(function).map(|(_, flag)| *flag)),
        })
        .collect()
}

/// Whether the standard has a function of this name.
pub(super) fn is_known(is_version_3: bool, name: &str) -> bool {
    if is_version_3 {
        Function3::ALL.iter().any(|function| function.name() == name)
    } else {
        Function::ALL.iter().any(|function| function.name() == name)
    }
}
