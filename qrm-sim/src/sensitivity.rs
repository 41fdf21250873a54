//! How a motion changes with its parameters: the motion itself on dual numbers, through generated code, assembly, steps and corrections.
//!
//! What comes out are the derivatives of what the steps compute, to rounding errors; against those of the exact motion they have the
//! error of the method, of order 4 in the step.

mod careful;

use num_dual::Dual64;
use qrm_core::{Angles, Description, Dual, Kernel, MOST_STRAIN, Mechanism, Problem, State, stride};

use crate::assembly::{Free, assemble};
use crate::extremes::{Extremes, Tracker};
use crate::integral::Integral;
use crate::linear::Vector;
use crate::motion::{Breakdown, Method, Moment};
use crate::outcome::NoStart;
use crate::simulate::{Grid, locate};
use crate::walk::parameters;

/// A number that carries its derivative by one parameter.
type Number = Dual<Dual64>;

/// A value with its derivatives by the parameters, in the order in which these were asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub by: Vec<f64>,
}

/// What is known of an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputValues {
    /// At the end.
    pub end: Value,
    /// The smallest value, and when it occurs.
    pub minimum: [Value; 2],
    /// The largest value, and when it occurs.
    pub maximum: [Value; 2],
    /// The integral over time.
    pub integral: Value,
}

/// How a motion changes with its parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// When it ends.
    pub end_time: Value,
    /// Coordinates at the end. If that is where a condition becomes true, the derivatives tell of the end wherever it moves.
    pub q: Vec<Value>,
    /// Rates there.
    pub qd: Vec<Value>,
    /// The outputs.
    pub outputs: Vec<OutputValues>,
}

/// What is asked.
pub struct SensitivityRequest<'a> {
    /// By which parameters.
    pub by: &'a [&'a str],
    /// The step in seconds; the scene's if `None`.
    pub step: Option<f64>,
    /// The end; the scene's if `None`.
    pub end: Option<SensitivityEnd<'a>>,
}

/// Where the motion ends.
pub enum SensitivityEnd<'a> {
    /// At a time, whatever the parameters are.
    Time(f64),
    /// When a function of the parameter by which derivatives are taken, of time, coordinates and rates rises through zero.
    Condition(&'a DualCondition<'a>),
}

/// Such a function.
pub type DualCondition<'a> = dyn Fn(&str, Dual64, &[Dual64], &[Dual64]) -> Dual64 + 'a;

/// Why there are no derivatives.
#[derive(Clone, Debug, PartialEq)]
pub enum NoSensitivity {
    /// The motion cannot begin.
    NoStart(NoStart),
    /// A step could not be made.
    Broken {
        /// Where it began.
        t: f64,
        /// Why.
        reason: Breakdown,
    },
    /// Near this time the mechanism passes, or comes near, a position at which the constraints say too little: there the motion is found by
    /// other means, which have no derivatives.
    Singular {
        /// The time.
        t: f64,
    },
    /// At or after this time some formula has no value, or no derivative, as a root at zero.
    NotSmooth {
        /// The time.
        t: f64,
    },
    /// The stop condition holds at the start.
    StoppedAtStart,
    /// The stop condition did not become true.
    NotStopped {
        /// The latest end.
        end_time: f64,
    },
    /// The stop condition becomes true without passing through zero: a small change of a parameter may move the end far.
    Grazing {
        /// When.
        t: f64,
    },
    /// There is no parameter of this name.
    NoParameter {
        /// The name.
        name: String,
    },
    /// The mechanism is not described by formulae of its parameters.
    NoFormulae,
}

/// Derivatives of a motion's end and outputs by its parameters, at the values that `replace` gives them.
///
/// ```
/// # use qrm_core::Mechanism;
/// # use qrm_sim::sensitivity::{NoSensitivity, SensitivityRequest, sensitivity};
/// # fn by<X: Mechanism<N, M>, const N: usize, const M: usize>() -> Result<(), NoSensitivity> {
/// let request = SensitivityRequest { by: &["k", "c"], step: None, end: None };
/// let found = sensitivity::<X, N, M>(&|_| None, &request)?;
/// println!("the largest output {} and its derivatives {:?}", found.outputs[0].maximum[0].value, found.outputs[0].maximum[0].by);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// The motion does not come to its end, or is not smooth enough.
pub fn sensitivity<X: Mechanism<N, M>, const N: usize, const M: usize>(
    replace: &dyn Fn(&str) -> Option<f64>,
    request: &SensitivityRequest,
) -> Result<Sensitivity, NoSensitivity> {
    let mut all = Sensitivity::default();
    for (i, parameter) in request.by.iter().enumerate() {
        all.take(i, Pass::<X, N, M>::new(replace, parameter, request)?.run()?);
    }
    Ok(all)
}

/// The motion with its derivatives by one parameter.
struct Course<const N: usize> {
    end_time: Dual64,
    q: [Dual64; N],
    qd: [Dual64; N],
    end: Vec<Dual64>,
    extremes: Vec<Extremes<Dual64>>,
    integrals: Vec<Dual64>,
}

impl Sensitivity {
    /// Takes up the derivatives by the parameter in this place.
    fn take<const N: usize>(&mut self, place: usize, course: Course<N>) {
        if place == 0 {
            self.q = vec![Value::default(); N];
            self.qd = vec![Value::default(); N];
            self.outputs = vec![OutputValues::default(); course.end.len()];
        }
        self.end_time.take(course.end_time);
        for i in 0..N {
            self.q[i].take(course.q[i]);
            self.qd[i].take(course.qd[i]);
        }
        for (i, output) in self.outputs.iter_mut().enumerate() {
            output.end.take(course.end[i]);
            output.integral.take(course.integrals[i]);
            let Extremes { minimum, maximum } = course.extremes[i];
            for (values, found) in [(&mut output.minimum, minimum), (&mut output.maximum, maximum)] {
                values[0].take(found.0);
                values[1].take(found.1);
            }
        }
    }
}

impl Value {
    fn take(&mut self, number: Dual64) {
        self.value = number.re;
        self.by.push(number.eps);
    }
}

/// The motion on dual numbers.
struct Pass<'a, X: Mechanism<N, M>, const N: usize, const M: usize> {
    mechanism: X,
    kernel: X::Kernel<Number>,
    parameter: &'a str,
    request: &'a SensitivityRequest<'a>,
    grid: Grid,
    /// The end of the grid, and how it changes with the parameter.
    end_time: Number,
    state: State<Number, N, M>,
}

fn constant(value: f64) -> Number {
    Dual(Dual64::from(value))
}

impl<'a, X: Mechanism<N, M>, const N: usize, const M: usize> Pass<'a, X, N, M> {
    fn new(
        replace: &dyn Fn(&str) -> Option<f64>,
        parameter: &'a str,
        request: &'a SensitivityRequest<'a>,
    ) -> Result<Self, NoSensitivity> {
        let mechanism = X::with_parameters(replace);
        let value = value_of(&X::DESCRIPTION, &mechanism, parameter)
            .ok_or_else(|| NoSensitivity::NoParameter { name: parameter.to_owned() })?;
        let seeded = Dual(Dual64::new(value, 1.0));
        let numbers = |name: &str| if name == parameter { Some(seeded) } else { replace(name).map(constant) };
        let Problem { kernel, start, schedule } =
            X::with_numbers::<Number>(&numbers).ok_or(NoSensitivity::NoFormulae)?;
        let end_time = match request.end {
            Some(SensitivityEnd::Time(t)) => constant(t),
            _ => schedule.end_time,
        };
        let grid = Grid { step: request.step.unwrap_or(schedule.step.0.re), end_time: end_time.0.re };
        if !(grid.step > grid.end_time * f64::EPSILON) {
            return Err(NoSensitivity::NoStart(NoStart::StepTooShort { step: grid.step, end_time: grid.end_time }));
        }
        let given = mechanism.start();
        let (q, qd) = assemble(&mechanism, &given).map_err(|e| NoSensitivity::NoStart(NoStart::NotAssembled(e)))?;
        // What is given may depend on the parameter, the rest follows by the constraints.
        let jacobian = mechanism.closure(0.0, &q).constraint_jacobian;
        let mut q = std::array::from_fn(|i| if given.given[i] { start.q[i] } else { constant(q[i]) });
        let angles = Angles::new(&q, X::Kernel::<Number>::IS_ANGLE);
        let open = kernel.residuals(&kernel.position(constant(0.0), &q, &angles));
        follow(&jacobian, &given.given, &open, &mut q);
        let angles = Angles::new(&q, X::Kernel::<Number>::IS_ANGLE);
        let position = kernel.position(constant(0.0), &q, &angles);
        let mut qd = std::array::from_fn(|i| if given.given_rates[i] { start.qd[i] } else { constant(qd[i]) });
        follow(&jacobian, &given.given_rates, &kernel.drift(&position, &qd), &mut qd);
        let mut state = State::new(&kernel, constant(0.0), q, qd);
        if !(kernel.strain(&position).0.re <= MOST_STRAIN && state.checksum().0.re == 0.0) {
            // A step of no length.
            let broken = |reason| NoSensitivity::Broken { t: 0.0, reason };
            let made = careful::step(&mechanism, &kernel, constant(0.0), constant(0.0), &state).map_err(broken)?;
            state = made.ok_or(NoSensitivity::Singular { t: 0.0 })?;
        }
        let state = smooth(constant(0.0), state)?;
        Ok(Self { mechanism, kernel, parameter, request, grid, end_time, state })
    }

    fn run(mut self) -> Result<Course<N>, NoSensitivity> {
        let outputs = X::DESCRIPTION.outputs.len();
        let mut trackers = vec![Tracker::default(); outputs];
        let mut integrals = vec![Integral::default(); outputs];
        let mut row = vec![constant(0.0); outputs];
        let mut take = |kernel: &X::Kernel<Number>, t: Number, at: &State<Number, N, M>| {
            kernel.outputs(t, &at.q, &at.qd, &at.qdd, &at.multipliers, &mut row);
            for (i, value) in row.iter().enumerate() {
                if !(value.0.re.is_finite() && value.0.eps.is_finite()) {
                    return Err(NoSensitivity::NotSmooth { t: t.0.re });
                }
                trackers[i].row(t.0, value.0);
                integrals[i].row(t.0, value.0);
            }
            Ok(row.iter().map(|value| value.0).collect::<Vec<Dual64>>())
        };
        let mut end = take(&self.kernel, constant(0.0), &self.state)?;
        let (mut t, mut row_number) = (constant(0.0), 0);
        let mut condition = self.condition(t, &self.state);
        if condition.is_some_and(|c| c.re >= 0.0) {
            return Err(NoSensitivity::StoppedAtStart);
        }
        while t.0.re < self.grid.end_time && condition.is_none_or(|c| c.re < 0.0) {
            row_number += 1;
            let t_next = constant(self.grid.time(row_number));
            let t_next = if t_next.0.re < self.grid.end_time { t_next } else { self.end_time };
            let mut made = (t_next, self.step(t, t_next - t)?);
            condition = self.condition(made.0, &made.1);
            if condition.is_some_and(|c| c.re >= 0.0) {
                made = self.stop(t, made)?;
            }
            (t, self.state) = made;
            end = take(&self.kernel, t, &self.state)?;
        }
        if condition.is_some_and(|c| !(c.re >= 0.0)) {
            return Err(NoSensitivity::NotStopped { end_time: self.grid.end_time });
        }
        Ok(Course {
            end_time: t.0,
            q: self.state.q.map(|number| number.0),
            qd: self.state.qd.map(|number| number.0),
            end,
            extremes: trackers.iter().filter_map(Tracker::finish).collect(),
            integrals: integrals.iter().map(Integral::finish).collect(),
        })
    }

    // Compiled once: it holds the whole step.
    #[inline(never)]
    fn step(&self, t: Number, h: Number) -> Result<State<Number, N, M>, NoSensitivity> {
        let made = stride(&self.kernel, t, h, &self.state);
        if made.is_good(Method::default().tolerance.residual) {
            return smooth(t, made.end);
        }
        let broken = |reason| NoSensitivity::Broken { t: t.0.re, reason };
        let made = careful::step(&self.mechanism, &self.kernel, t, h, &self.state).map_err(broken)?;
        made.map_or(Err(NoSensitivity::Singular { t: t.0.re }), |end| smooth(t, end))
    }

    /// How far the stop condition is from true, if there is one.
    fn condition(&self, t: Number, at: &State<Number, N, M>) -> Option<Dual64> {
        match self.request.end {
            Some(SensitivityEnd::Time(_)) => None,
            Some(SensitivityEnd::Condition(condition)) => {
                Some(condition(self.parameter, t.0, &at.q.map(|x| x.0), &at.qd.map(|x| x.0)))
            }
            None => self.kernel.ending(t, &at.q, &at.qd).map(|value| value.0),
        }
    }

    /// When the condition becomes true in the step that begins at `t`, and how that moves with the parameter.
    fn stop(
        &self,
        t: Number,
        beyond: (Number, State<Number, N, M>),
    ) -> Result<(Number, State<Number, N, M>), NoSensitivity> {
        let plain = |t: Number, at: &State<Number, N, M>| Moment {
            t: t.0.re,
            q: at.q.map(|x| x.0.re),
            qd: at.qd.map(|x| x.0.re),
            qdd: at.qdd.map(|x| x.0.re),
            multipliers: at.multipliers.map(|x| x.0.re),
            corrections: 0,
        };
        let of_plain = |at: &Moment<N, M>| {
            let state = State { q: at.q.map(constant), qd: at.qd.map(constant), ..self.state };
            self.condition(constant(at.t), &state).map_or(0.0, |c| c.re)
        };
        let step = |to: f64| {
            let made = self.step(t, constant(to - t.0.re));
            made.map(|at| plain(constant(to), &at)).map_err(|_| Breakdown::NotFinite)
        };
        let found = locate(&plain(t, &self.state), &plain(beyond.0, &beyond.1), of_plain, step);
        let end = found.map_err(|_| NoSensitivity::Singular { t: t.0.re })?.t;
        // How the condition changes with the parameter there, and with the parameter and time together.
        let change = |end: Number| Ok(self.condition(end, &self.step(t, end - t)?).map_or(0.0, |c| c.eps));
        let by_parameter = change(constant(end))?;
        let rise = change(Dual(Dual64::new(end, 1.0)))? - by_parameter;
        if !(rise > 0.0) {
            return Err(NoSensitivity::Grazing { t: end });
        }
        let end = Dual(Dual64::new(end, -by_parameter / rise));
        Ok((end, self.step(t, end - t)?))
    }
}

/// A state, if its derivatives are finite.
fn smooth<const N: usize, const M: usize>(
    t: Number,
    state: State<Number, N, M>,
) -> Result<State<Number, N, M>, NoSensitivity> {
    if state.checksum().0.eps == 0.0 { Ok(state) } else { Err(NoSensitivity::NotSmooth { t: t.0.re }) }
}

/// The value of a parameter.
fn value_of<X: Mechanism<N, M>, const N: usize, const M: usize>(
    description: &Description,
    mechanism: &X,
    name: &str,
) -> Option<f64> {
    let place = description.parameters.iter().position(|parameter| parameter.name == name)?;
    parameters(mechanism).get(place).copied()
}

/// Lets those of `x` that are not given follow by the constraints, `C_q dx = -open` in derivatives.
fn follow<const N: usize, const M: usize>(
    jacobian: &[Vector<N>; M],
    given: &[bool; N],
    open: &[Number; M],
    x: &mut [Number; N],
) {
    let mut change = x.map(|number| number.0.eps);
    Free::new(jacobian, given).follow(&mut change, &open.map(|residual| residual.0.eps));
    for i in 0..N {
        x[i].0.eps = change[i];
    }
}
