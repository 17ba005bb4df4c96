//! The functions of FMI 3.0 for co-simulation. What a unit does not support fails with an error.
//!
//! Standard: Modelica Association, Functional Mock-up Interface 3.0.2, 2024, sections 2 and 4.

use std::ffi::{c_char, c_int, c_void};
use std::fs;
use std::path::Path;
use std::ptr;

use sim::fmu::{Instance, SCENE_FILE, StepError, Value};

use crate::failure::{keep, kept, sonoglide_failure};
use crate::pointers;

/// Status of a call.
const OK: c_int = 0;
const ERROR: c_int = 3;

/// Function that receives messages: environment, status, category, message.
type LogMessage = Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char)>;

/// Unit in use.
struct Unit {
    instance: Instance,
    environment: *mut c_void,
    log: LogMessage,
}

impl Unit {
    /// Returns the status of some work, and reports its failure.
    fn status(&mut self, work: impl FnOnce(&mut Self) -> Result<(), String>) -> c_int {
        match kept(|| work(self)) {
            Some(()) => OK,
            None => {
                // SAFETY: the caller gave the function with its environment.
                unsafe { said(self.log, self.environment) };
                ERROR
            }
        }
    }
}

/// Passes the last failure to the caller.
///
/// # Safety
/// `log` accepts `environment`.
unsafe fn said(log: LogMessage, environment: *mut c_void) {
    if let Some(log) = log {
        // SAFETY: guaranteed by the caller; the texts end with a zero byte.
        unsafe { log(environment, ERROR, c"error".as_ptr(), sonoglide_failure()) };
    }
}

/// Runs a function of a unit.
///
/// # Safety
/// `unit` comes from `fmi3InstantiateCoSimulation`, and nobody else uses it meanwhile.
unsafe fn on(unit: *mut c_void, work: impl FnOnce(&mut Unit) -> Result<(), String>) -> c_int {
    // SAFETY: guaranteed by the caller.
    match unsafe { pointers::object(unit.cast::<Unit>()) } {
        Ok(unit) => unit.status(work),
        Err(misuse) => {
            keep(&misuse);
            ERROR
        }
    }
}

/// Returns the version of the standard.
#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Creates a unit from the scene in its folder of resources.
///
/// # Safety
/// Texts end with a zero byte; `log` accepts `environment`.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _events: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _update: *const c_void,
) -> *mut c_void {
    let made = kept(|| -> Result<_, String> {
        // SAFETY: guaranteed by the caller.
        let (token, resources) = unsafe { (pointers::text(token), pointers::text(resources)) };
        let (token, resources) = (token.map_err(|misuse| misuse.to_string())?, resources.map_err(|misuse| misuse.to_string())?);
        if resources.is_empty() {
            return Err("the path of the resources is empty".to_owned());
        }
        let path = Path::new(resources).join(SCENE_FILE);
        let text = fs::read_to_string(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let instance = Instance::new(&text, token).map_err(|error| error.to_string())?;
        Ok(Box::new(Unit { instance, environment, log }))
    });
    if made.is_none() {
        // SAFETY: guaranteed by the caller.
        unsafe { said(log, environment) };
    }
    made.map_or(ptr::null_mut(), |unit| Box::into_raw(unit).cast())
}

/// Frees a unit.
///
/// # Safety
/// `unit` is null or comes from `fmi3InstantiateCoSimulation`, and is not used any more.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(unit: *mut c_void) {
    // SAFETY: guaranteed by the caller.
    unsafe { pointers::free(unit.cast::<Unit>()) };
}

/// Begins the initialisation; a unit starts at the time zero.
///
/// # Safety
/// As of [`on`].
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    unit: *mut c_void,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
    _has_stop: bool,
    _stop_s: f64,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe {
        on(unit, |_| match start_s {
            0.0 => Ok(()),
            _ => Err(format!("a start at {start_s} s: this unit starts at 0 s")),
        })
    }
}

/// Functions that change nothing in a unit.
macro_rules! nothing_to_do {
    ($($name:ident)+) => {$(
        /// Does nothing.
        ///
        /// # Safety
        /// As of [`on`].
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(unit: *mut c_void) -> c_int {
            // SAFETY: guaranteed by the caller.
            unsafe { on(unit, |_| Ok(())) }
        }
    )+};
}

nothing_to_do! { fmi3ExitInitializationMode fmi3EnterStepMode fmi3Terminate }

/// Accepts any setting of the messages: a unit has only errors.
///
/// # Safety
/// As of [`on`].
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetDebugLogging(unit: *mut c_void, _on: bool, _count: usize, _categories: *const c_void) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { on(unit, |_| Ok(())) }
}

/// Returns a unit to its start.
///
/// # Safety
/// As of [`on`].
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(unit: *mut c_void) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { on(unit, |unit| unit.instance.reset().map_err(|error| error.to_string())) }
}

/// Advances a unit by its step.
///
/// # Safety
/// As of [`on`]; the results are null or have room for one value.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    unit: *mut c_void,
    from_s: f64,
    step_s: f64,
    _no_return: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    reached_s: *mut f64,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe {
        on(unit, |unit| {
            let stepped = unit.instance.step(from_s, step_s).map_err(|error| error.to_string());
            for flag in [event, terminate, early] {
                if let Some(flag) = flag.as_mut() {
                    *flag = false;
                }
            }
            if let Some(reached_s) = reached_s.as_mut() {
                *reached_s = unit.instance.time_s();
            }
            stepped
        })
    }
}

/// Functions that read and set variables of one type.
macro_rules! of_type {
    ($get:ident $set:ident $type:ty, $kind:ident) => {
        /// Reads variables.
        ///
        /// # Safety
        /// As of [`on`]; the arrays have the sizes stated.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $get(
            unit: *mut c_void,
            references: *const u32,
            count: usize,
            values: *mut $type,
            values_count: usize,
        ) -> c_int {
            // SAFETY: guaranteed by the caller.
            unsafe {
                on(unit, |unit| {
                    let references = pointers::read(references, count).map_err(|misuse| misuse.to_string())?;
                    let values = pointers::write(values, values_count).map_err(|misuse| misuse.to_string())?;
                    scalars(references, values.len())?;
                    for (reference, value) in references.iter().zip(values) {
                        match unit.instance.get(*reference) {
                            Some(Value::$kind(found)) => *value = *found,
                            _ => return Err(StepError::Unknown(*reference).to_string()),
                        }
                    }
                    Ok(())
                })
            }
        }

        /// Sets variables.
        ///
        /// # Safety
        /// As of [`on`]; the arrays have the sizes stated.
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $set(
            unit: *mut c_void,
            references: *const u32,
            count: usize,
            values: *const $type,
            values_count: usize,
        ) -> c_int {
            // SAFETY: guaranteed by the caller.
            unsafe {
                on(unit, |unit| {
                    let references = pointers::read(references, count).map_err(|misuse| misuse.to_string())?;
                    let values = pointers::read(values, values_count).map_err(|misuse| misuse.to_string())?;
                    scalars(references, values.len())?;
                    let mut both = references.iter().zip(values);
                    both.try_for_each(|(reference, value)| unit.instance.set(*reference, Value::$kind(*value)))
                        .map_err(|error| error.to_string())
                })
            }
        }
    };
}

of_type! { fmi3GetInt32 fmi3SetInt32 i32, Integer }
of_type! { fmi3GetBoolean fmi3SetBoolean bool, Boolean }
of_type! { fmi3GetUInt64 fmi3SetUInt64 u64, Unsigned }
of_type! { fmi3GetFloat64 fmi3SetFloat64 f64, Float }

/// Checks that scalars have one value each.
fn scalars(references: &[u32], values: usize) -> Result<(), String> {
    if references.len() == values { Ok(()) } else { Err(format!("{} variables, but {values} values", references.len())) }
}

/// Reads arrays of codes, one after the other.
///
/// # Safety
/// As of [`on`]; the arrays have the sizes stated.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetUInt16(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut u16,
    values_count: usize,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe {
        on(unit, |unit| {
            let references = pointers::read(references, count).map_err(|misuse| misuse.to_string())?;
            let mut rest = pointers::write(values, values_count).map_err(|misuse| misuse.to_string())?;
            for reference in references {
                let codes = codes(&unit.instance, *reference)?;
                let (into, after) = rest.split_at_mut_checked(codes.len()).ok_or("too few values")?;
                into.copy_from_slice(codes);
                rest = after;
            }
            if rest.is_empty() { Ok(()) } else { Err("too many values".to_owned()) }
        })
    }
}

/// Sets arrays of codes, one after the other.
///
/// # Safety
/// As of [`on`]; the arrays have the sizes stated.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetUInt16(
    unit: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const u16,
    values_count: usize,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe {
        on(unit, |unit| {
            let references = pointers::read(references, count).map_err(|misuse| misuse.to_string())?;
            let mut rest = pointers::read(values, values_count).map_err(|misuse| misuse.to_string())?;
            for reference in references {
                let length = codes(&unit.instance, *reference)?.len();
                let (own, after) = rest.split_at_checked(length).ok_or("too few values")?;
                unit.instance.set(*reference, Value::Codes(own.to_vec())).map_err(|error| error.to_string())?;
                rest = after;
            }
            if rest.is_empty() { Ok(()) } else { Err("too many values".to_owned()) }
        })
    }
}

fn codes(instance: &Instance, reference: u32) -> Result<&[u16], String> {
    match instance.get(reference) {
        Some(Value::Codes(codes)) => Ok(codes),
        _ => Err(StepError::Unknown(reference).to_string()),
    }
}

/// Functions of the standard that a unit does not support. Their arguments do not matter.
macro_rules! unsupported {
    ($($name:ident)+) => {$(
        /// Fails: a unit does not support this.
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> c_int {
            keep(&concat!("this unit does not support ", stringify!($name)));
            ERROR
        }
    )+};
}

unsupported! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt32 fmi3GetInt64 fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt32 fmi3SetInt64 fmi3SetBinary fmi3SetClock
    fmi3SetString fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState fmi3GetDirectionalDerivative
    fmi3GetAdjointDerivative fmi3EnterConfigurationMode fmi3ExitConfigurationMode fmi3GetIntervalDecimal fmi3GetIntervalFraction
    fmi3GetShiftDecimal fmi3GetShiftFraction fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal
    fmi3SetShiftFraction fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3EnterEventMode fmi3EnterContinuousTimeMode
    fmi3CompletedIntegratorStep fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates
    fmi3GetOutputDerivatives fmi3ActivateModelPartition
}

/// Functions that create a unit of another kind.
macro_rules! no_unit {
    ($($name:ident)+) => {$(
        /// Returns null: a unit is for co-simulation only.
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> *mut c_void {
            keep(&"this unit is for co-simulation only");
            ptr::null_mut()
        }
    )+};
}

no_unit! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }
