//! The sections on cut loops and on the equations of motion.

use super::Derivation;
use super::matrix::vector;
use super::notation::{plain, set};
use crate::term::{Symbol, Term};

impl Derivation<'_> {
    pub(super) fn constraints(&self) -> String {
        let e = self.equations;
        if self.scene.constraints.is_empty() {
            return String::new();
        }
        let is_driven = self.scene.is_driven();
        let (more, of) = if is_driven { (", `constraint_rate`", "@C(@q, t)") } else { ("", "@C(@q)") };
        let mut text = format!("## Cut loops: `constraints`, `constraint_jacobian`{more}, `constraint_bias`\n\n");
        for constraint in &self.scene.constraints {
            let doc = if constraint.doc.is_empty() { String::new() } else { format!(", {}", plain(&constraint.doc)) };
            text += &format!("- `{}`: `{} = 0`{doc}\n", constraint.name, self.words.formula(&constraint.residual));
        }
        let name = |i: usize| format!(r"C_{{\mathrm{{{}}}}}", plain(&self.scene.constraints[i].name));
        let column = vector(&(0..e.constraints.len()).map(name).collect::<Vec<_>>());
        text += &format!("\n$${} = {column}$$\n", set(of));
        for (i, term) in e.constraints.iter().enumerate() {
            text += &format!("\n{}\n", self.equation(&name(i), term));
        }
        text += &format!("\n{}\n", self.matrix(&set("@C_{@q}"), &e.constraint_jacobian));
        if is_driven {
            text += "\nThey move by themselves:\n\n";
            text += &self.vector(&set("@C_t"), &set("@C_t"), &e.constraint_rate);
            text += "\n";
        }
        // Second derivatives are not written out if quantities have names.
        let is_shown = e.names.is_empty();
        if is_shown && e.constraint_hessians.iter().flatten().flatten().all(Term::is_zero) {
            text += "\nAll second derivatives are zero.\n";
            return text + self.driven_bias().as_str();
        }
        if is_shown {
            text += &self.second_derivatives(name);
        }
        if is_driven {
            return text + self.driven_bias().as_str();
        }
        let they = if is_shown { "They" } else { "\nSecond derivatives" };
        text += &format!("{they} enter the motion through their contraction with the rates alone:\n\n");
        text += &self.vector(&set(r"(@C_{@q}\,@qd)_{@q}\,@qd"), r"\mathcal{D}", &e.constraint_bias);
        text + "\n"
    }

    /// Writes the nonzero entries of C_qq; `name` returns the name of a constraint.
    fn second_derivatives(&self, name: impl Fn(usize) -> String) -> String {
        let mut text = "\nThe second derivatives that are not zero:\n\n".to_owned();
        for (k, hessian) in self.equations.constraint_hessians.iter().enumerate() {
            for (i, row) in hessian.iter().enumerate() {
                for (j, entry) in row.iter().enumerate().take(i + 1).filter(|(_, entry)| !entry.is_zero()) {
                    let [a, b] = [i, j].map(|i| self.symbol(Symbol::Coordinate(i)));
                    let by =
                        if i == j { format!(r"\partial {a}^{{2}}") } else { format!(r"\partial {a}\,\partial {b}") };
                    let derivative = format!(r"\frac{{\partial^{{2}} {}}}{{{by}}}", name(k));
                    text += &format!("{}\n\n", self.equation(&derivative, entry));
                }
            }
        }
        text
    }

    /// Writes the second rates of constraints that depend on time, without `C_q qdd`.
    fn driven_bias(&self) -> String {
        if !self.scene.is_driven() {
            return String::new();
        }
        let bias = set(r"(@C_{@q}\,@qd)_{@q}\,@qd + 2\,@C_{@q t}\,@qd + @C_{tt}");
        let vector = self.vector(&bias, r"\mathcal{D}", &self.equations.constraint_bias);
        format!("\nBeside the accelerations, their second rates have\n\n{vector}\n")
    }

    pub(super) fn motion(&self) -> String {
        if self.scene.constraints.is_empty() {
            let function = if self.equations.has_momenta() { "accelerations" } else { "dynamics" };
            return format!("## Equations of motion: `{function}`\n\n{}\n", set(r"$$@m\,@qdd = @f$$"));
        }
        let system = set(r"\begin{pmatrix} @m & @C_{@q}^{T} \\ @C_{@q} & 0 \end{pmatrix}
\begin{pmatrix} @qdd \\ @l \end{pmatrix} =
\begin{pmatrix} @f \\ -(@C_{@q}\,@qd)_{@q}\,@qd# \end{pmatrix}");
        let is_driven = self.scene.is_driven();
        let system =
            system.replace('#', &if is_driven { set(r" - 2\,@C_{@q t}\,@qd - @C_{tt}") } else { String::new() });
        let (lambda, column) = (set("@l"), self.column(Symbol::Multiplier));
        let (closed, tangent) = match is_driven {
            true => ("$@C(@q, t) = 0$", r"$@C_{@q}\,@qd + @C_t = 0$"),
            false => ("$@C(@q) = 0$", r"$@C_{@q}\,@qd = 0$"),
        };
        let words = set("The force of a constraint $C$ with the multiplier $\\lambda$ on a point $P$ is \
             $-\\lambda\\,\\partial C/\\partial P$, the coordinates of other points and all angles held. After each \
             step positions are put back onto #closed, rates onto #tangent.");
        let words = words.replace("#closed", &set(closed)).replace("#tangent", &set(tangent));
        format!(
            "## Equations of motion: `dynamics`, `loop_constraints`\n\n$${}, \\qquad {lambda} = \
             {column}$$\n\n{words}\n",
            system.replace('\n', " ")
        )
    }
}
