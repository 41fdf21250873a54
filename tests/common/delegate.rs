//! Mechanisms without a kernel around another mechanism.

/// The methods of `Mechanism` by the mechanism in a field, without kernel and steps; mass matrix, dynamics and loop
/// constraints are left to the caller.
macro_rules! delegate_without_kernel {
    ($field:tt) => {
        fn description(&self) -> &'static qrm_core::Description {
            self.$field.description()
        }

        fn parameters(&self) -> &[f64] {
            self.$field.parameters()
        }

        fn is_driven(&self) -> bool {
            self.$field.is_driven()
        }

        fn has_linearization(&self) -> bool {
            self.$field.has_linearization()
        }

        fn operations(&self) -> usize {
            self.$field.operations()
        }

        fn start(&self, start: qrm_core::StartMut) {
            self.$field.start(start);
        }

        fn schedule(&self) -> qrm_core::Schedule<f64> {
            self.$field.schedule()
        }

        fn event(&self, at: &qrm_core::StateRef) -> Option<f64> {
            self.$field.event(at)
        }

        fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
            self.$field.energy(q, qd)
        }

        fn power(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64]) -> f64 {
            self.$field.power(t, q, qd, qdd, multipliers)
        }

        fn outputs(&self, t: f64, q: &[f64], qd: &[f64], qdd: &[f64], multipliers: &[f64], outputs: &mut [f64]) {
            self.$field.outputs(t, q, qd, qdd, multipliers, outputs);
        }

        fn linearization(
            &self,
            t: f64,
            q: &[f64],
            qd: &[f64],
            qdd: &[f64],
            multipliers: &[f64],
            linearization: qrm_core::LinearizationMut,
        ) -> bool {
            self.$field.linearization(t, q, qd, qdd, multipliers, linearization)
        }
    };
}
