//! The kernel of a tape.

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};

use crate::angles::Angles;
use crate::description::Description;
use crate::kernel::Kernel;
use crate::scalar::Scalar;
use crate::tape::{Arguments, Tape, TapeFunction, TapeKernel, execute};

/// Positions that can be used at the same time: see [`Kernel::Position`].
const POSITIONS: usize = 2;

// The places of the functions in their list.
const POSITION: usize = 0;
const VELOCITY_RESIDUAL: usize = 1;
const CORRECTION: usize = 2;
const ACCELERATIONS: usize = 3;
const MULTIPLIERS: usize = 4;
const OUTPUTS: usize = 5;

/// The kernel of a tape with up to `C` coordinates and constraints.
#[derive(Clone, Debug)]
pub(crate) struct InterpretedKernel<R, const C: usize> {
    tape: &'static Tape,
    arguments: Arguments,
    /// The place of the first value of each function.
    places: [usize; TapeKernel::FUNCTIONS],
    is_length: [bool; C],
    has_angle: [bool; C],
    /// The values at all places of the tape for each position, and those for functions without a position.
    values: [RefCell<Vec<R>>; POSITIONS + 1],
    /// How many positions there were.
    count: Cell<usize>,
}

/// The number of a position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PositionNumber(usize);

impl<R: Scalar, const C: usize> InterpretedKernel<R, C> {
    /// The kernel of a mechanism; its parameters are yet to be set. `None` if the mechanism is too large.
    pub(crate) fn new(tape: &'static Tape, description: &Description) -> Option<Self> {
        let [n, m] = tape.sizes();
        if n > C || m > C {
            return None;
        }
        Some(Self {
            tape,
            arguments: tape.arguments(),
            places: tape.kernel_places(),
            is_length: core::array::from_fn(|i| i < n && !description.is_angle(i)),
            has_angle: core::array::from_fn(|i| tape.kernel.has_angle.get(i) == Some(&true)),
            values: [(); POSITIONS + 1].map(|()| RefCell::new(vec![R::zero(); tape.places()])),
            count: Cell::new(0),
        })
    }

    /// Executes a function of a position, with arguments at their places, and gives what `results` makes of the values.
    #[inline(always)]
    fn run<T>(
        &self,
        PositionNumber(position): PositionNumber,
        function: usize,
        arguments: &[(usize, &[R])],
        results: impl FnOnce(&[R], &[u32]) -> T,
    ) -> T {
        assert!(self.count.get() < position + POSITIONS, "the position has been replaced");
        let values = &mut *self.values[position % POSITIONS].borrow_mut();
        write::<R, C>(values, arguments);
        let TapeFunction { operations, results: places } = self.tape.kernel.functions()[function];
        execute(values, self.places[function], operations);
        results(values, places)
    }

    /// The value of one of the functions without a position, for coordinates, rates and accelerations.
    fn evaluate(&self, function: &TapeFunction, t: R, motion: [&[R; C]; 3], multipliers: &[R; C]) -> R {
        let (values, at) = (&mut *self.values[POSITIONS].borrow_mut(), &self.arguments);
        let [q, qd, qdd] = motion.map(|x| self.coordinates(x));
        let multipliers = (at.multipliers, self.constraints(multipliers));
        write::<R, C>(values, &[(at.t, &[t]), (at.q, q), (at.qd, qd), (at.qdd, qdd), multipliers]);
        execute(values, at.end, &function.operations);
        function.results.first().map_or(R::zero(), |&place| values[place as usize])
    }

    /// The part of a padded vector that belongs to coordinates.
    fn coordinates<'x>(&self, x: &'x [R; C]) -> &'x [R] {
        &x[..self.tape.coordinates as usize]
    }

    /// The part of a padded vector that belongs to constraints.
    fn constraints<'x>(&self, x: &'x [R; C]) -> &'x [R] {
        &x[..self.tape.constraints as usize]
    }
}

/// Writes vectors with up to `C` numbers to their places, one number after another: a copy of unknown length would wait
/// until the numbers have left the processor.
#[inline(always)]
fn write<R: Copy, const C: usize>(values: &mut [R], arguments: &[(usize, &[R])]) {
    for (place, argument) in arguments {
        let values = &mut values[*place..][..argument.len()];
        for i in 0..C {
            let (Some(value), Some(number)) = (values.get_mut(i), argument.get(i)) else { break };
            *value = *number;
        }
    }
}

/// The values at some places, zeros behind them.
#[inline(always)]
fn read<R: Scalar, const C: usize>(values: &[R], places: &[u32]) -> [R; C] {
    let mut results = [R::zero(); C];
    for (result, &place) in results.iter_mut().zip(places) {
        *result = values[place as usize];
    }
    results
}

impl<R: Scalar, const C: usize> Kernel<R, C, C> for InterpretedKernel<R, C> {
    type Position = PositionNumber;

    // Whatever the scene, there is one place where operations are executed. Long vectors are costly to compile.
    const OPERATIONS: usize = if C > 8 { usize::MAX } else { 1 };

    fn sizes(&self) -> [usize; 2] {
        self.tape.sizes()
    }

    fn has_angle(&self) -> [bool; C] {
        self.has_angle
    }

    fn is_length(&self) -> [bool; C] {
        self.is_length
    }

    fn set_values(&mut self, value: &dyn Fn(usize) -> R) {
        let [first, others @ ..] = &mut self.values;
        let first = first.get_mut();
        first.iter_mut().take(self.arguments.t).enumerate().for_each(|(i, parameter)| *parameter = value(i));
        execute(first, self.arguments.constants, &self.tape.constants);
        others.iter_mut().for_each(|other| other.get_mut().copy_from_slice(first));
    }

    fn position(&self, t: R, q: &[R; C], angles: &Angles<R, C>) -> PositionNumber {
        let (position, at) = (PositionNumber(self.count.get() + 1), &self.arguments);
        self.count.set(position.0);
        let [sin, cos] = [&angles.sin, &angles.cos].map(|x| self.coordinates(x));
        let arguments = [(at.t, &[t][..]), (at.q, self.coordinates(q)), (at.sin, sin), (at.cos, cos)];
        self.run(position, POSITION, &arguments, |_, _| ());
        position
    }

    #[inline(always)]
    fn residuals(&self, position: &PositionNumber) -> [R; C] {
        let places = self.tape.kernel.position.results.get(1..).unwrap_or_default();
        read(&self.values[position.0 % POSITIONS].borrow(), places)
    }

    #[inline(always)]
    fn growth_factor(&self, position: &PositionNumber) -> R {
        read::<R, 1>(&self.values[position.0 % POSITIONS].borrow(), &self.tape.kernel.position.results)[0]
    }

    #[inline(always)]
    fn velocity_residual(&self, position: &PositionNumber, qd: &[R; C]) -> [R; C] {
        let arguments = [(self.arguments.qd, self.coordinates(qd))];
        self.run(*position, VELOCITY_RESIDUAL, &arguments, read)
    }

    fn correction(&self, position: &PositionNumber, residuals: &[R; C]) -> [R; C] {
        let arguments = [(self.arguments.residuals, self.constraints(residuals))];
        self.run(*position, CORRECTION, &arguments, read)
    }

    fn accelerations(
        &self,
        position: &PositionNumber,
        t: R,
        q: &[R; C],
        qd: &[R; C],
        angles: &Angles<R, C>,
    ) -> ([R; C], [R; C]) {
        let qdd = self.stage_accelerations(position, t, q, qd, angles);
        (qdd, self.run(*position, MULTIPLIERS, &[], read))
    }

    fn stage_accelerations(
        &self,
        position: &PositionNumber,
        _t: R,
        _q: &[R; C],
        qd: &[R; C],
        _angles: &Angles<R, C>,
    ) -> [R; C] {
        self.run(*position, ACCELERATIONS, &[(self.arguments.qd, self.coordinates(qd))], read)
    }

    fn outputs_at(
        &self,
        position: &PositionNumber,
        _t: R,
        _q: &[R; C],
        qd: &[R; C],
        _angles: &Angles<R, C>,
        qdd: &[R; C],
        multipliers: &[R; C],
        outputs: &mut [R],
    ) {
        let at = &self.arguments;
        let [qd, qdd] = [qd, qdd].map(|x| self.coordinates(x));
        let arguments = [(at.qd, qd), (at.qdd, qdd), (at.multipliers, self.constraints(multipliers))];
        self.run(*position, OUTPUTS, &arguments, |values, places| {
            outputs.iter_mut().zip(places).for_each(|(output, &place)| *output = values[place as usize]);
        });
    }

    fn power(&self, t: R, q: &[R; C], qd: &[R; C], qdd: &[R; C], multipliers: &[R; C]) -> R {
        self.evaluate(&self.tape.power, t, [q, qd, qdd], multipliers)
    }

    fn event(&self, t: R, q: &[R; C], qd: &[R; C], qdd: &[R; C], multipliers: &[R; C]) -> Option<R> {
        Some(self.evaluate(self.tape.event.as_ref()?, t, [q, qd, qdd], multipliers))
    }
}
