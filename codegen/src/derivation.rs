//! The derivation of a scene's equations of motion, as Markdown with LaTeX, to be read beside a textbook.

mod matrix;

use crate::formula::{Style, Writer};
use crate::scene::Scene;
use crate::term::{Equations, Row, Symbol, Term};
use crate::words::Words;
use matrix::{entries, equation, matrix, vector};

/// The whole text.
pub fn markdown(scene: &Scene, equations: &Equations, source: &str) -> String {
    let writer = Writer::new(scene, Style::Latex).naming_roots(equations.terms());
    let derivation = Derivation { scene, equations, words: Words { source }, writer };
    let sections = [
        derivation.beginning(),
        derivation.coordinates(),
        derivation.points(),
        derivation.roots(),
        derivation.bodies(),
        derivation.jacobian(),
        derivation.mass(),
        derivation.loads(),
        derivation.constraints(),
        derivation.motion(),
        derivation.outputs(),
        derivation.left_out(),
    ];
    sections.into_iter().filter(|section| !section.is_empty()).collect::<Vec<_>>().join("\n")
}

struct Derivation<'a> {
    scene: &'a Scene,
    equations: &'a Equations,
    words: Words<'a>,
    writer: Writer<'a>,
}

impl Derivation<'_> {
    fn beginning(&self) -> String {
        let Scene { name, doc, .. } = self.scene;
        let doc = if doc.is_empty() { String::new() } else { format!("{doc}\n\n") };
        format!(
            "# {name}: the equations of motion\n\n{doc}Derived from `scenes/{name}.toml` by the TMT method: the positions of \
             the bodies are differentiated by the generalized coordinates, loops are cut and closed by constraints with \
             multipliers. These are the formulae behind the generated functions, whose names stand beside them.\n"
        )
    }

    fn coordinates(&self) -> String {
        let mut text = format!("## Coordinates and parameters\n\n$$q = {}$$\n\n", self.column(Symbol::Coordinate));
        text += "| symbol | name | unit | what |\n|---|---|---|---|\n";
        for (i, c) in self.scene.coordinates.iter().enumerate() {
            text += &format!(
                "| ${}$ | `{}` | {} | {} |\n",
                self.symbol(Symbol::Coordinate(i)),
                c.name,
                c.unit,
                cell(&c.doc)
            );
        }
        if !self.scene.parameters.is_empty() {
            text += "\n| symbol | name | value | unit | what |\n|---|---|---|---|---|\n";
        }
        for (i, p) in self.scene.parameters.iter().enumerate() {
            let zero = if p.left_out { ", left out" } else { "" };
            let symbol = self.symbol(Symbol::Parameter(i));
            text += &format!("| ${symbol}$ | `{}` | `{}`{zero} | {} | {} |\n", p.name, p.text, p.unit, cell(&p.doc));
        }
        text
    }

    fn points(&self) -> String {
        if self.scene.points.is_empty() {
            return String::new();
        }
        let mut text = String::from("## Points\n\n");
        for (point, position) in self.scene.points.iter().zip(&self.equations.points) {
            text += &format!("$${} = {}$$\n\n", matrix::name(&point.name), vector(&self.terms(position)));
        }
        text
    }

    fn roots(&self) -> String {
        let roots = self.writer.roots();
        let lines = roots.iter().map(|(name, root)| format!("$${name} = {root}$$\n")).collect::<Vec<_>>().join("\n");
        if roots.is_empty() { lines } else { format!("For short:\n\n{lines}") }
    }

    fn bodies(&self) -> String {
        let mut text = String::from(
            "## Bodies: `com_positions`\n\n$x(q)$ stacks the positions of the centres of mass and the angles of the bodies, \
             as far as they carry inertia and move:\n\n| row | what | $x_i$ | $M_{ii}$ |\n|---|---|---|---|\n",
        );
        for (i, (row, x)) in self.equations.rows.iter().zip(&self.equations.com_positions).enumerate() {
            let (what, x, inertia) = (self.row(row), self.writer.term(x), self.writer.term(&row.inertia));
            text += &format!("| {} | {what} | ${x}$ | ${inertia}$ |\n", i + 1);
        }
        text
    }

    fn jacobian(&self) -> String {
        let e = self.equations;
        format!(
            "## Transformation matrix and convective accelerations: `com_jacobian`, `com_bias`\n\n\
             $$\\dot x = T\\,\\dot q, \\qquad T = \\frac{{\\partial x}}{{\\partial q}}$$\n\n{}\n\n\
             $$\\ddot x = T\\,\\ddot q + (T\\dot q)_q\\,\\dot q$$\n\n{}\n",
            self.matrix("T", &e.com_jacobian),
            self.vector(r"(T\dot q)_q\,\dot q", "b", &e.com_bias),
        )
    }

    fn mass(&self) -> String {
        format!(
            "## Reduced mass matrix: `mass_matrix`\n\n$$\\bar M = T^{{T}} M\\,T$$\n\n{}\n",
            self.matrix(r"\bar M", &self.equations.mass_matrix)
        )
    }

    fn loads(&self) -> String {
        let mut text = String::from("## Loads and reduced forces: `generalized_forces`, `energy`, `power`\n\n");
        for load in &self.scene.loads {
            text += &format!("- `{}`: {}\n", load.name, self.words.load(&load.kind));
        }
        if self.scene.loads.is_empty() {
            text += "There are no loads.\n";
        }
        text += &format!(
            "\n$$\\bar f = Q + T^{{T}}\\left(F - M\\,(T\\dot q)_q\\,\\dot q\\right)$$\n\n{}\n\nKinetic energy, and the potential \
             of the loads that have one:\n\n{}\n\n{}\n",
            self.vector(r"\bar f", r"\bar f", &self.equations.generalized_forces),
            self.equation("E_k", &self.equations.energy[0]),
            self.equation("V", &self.equations.energy[1])
        );
        if !self.equations.power[0].is_zero() {
            text += &format!("\nPower of the others:\n\n{}\n", self.equation("P", &self.equations.power[0]));
        }
        text
    }

    fn constraints(&self) -> String {
        let e = self.equations;
        if self.scene.constraints.is_empty() {
            return String::new();
        }
        let mut text = String::from("## Cut loops: `constraints`, `constraint_jacobian`, `constraint_bias`\n\n");
        for constraint in &self.scene.constraints {
            let doc = if constraint.doc.is_empty() { String::new() } else { format!(", {}", constraint.doc) };
            text += &format!("- `{}`: `{} = 0`{doc}\n", constraint.name, self.words.formula(&constraint.residual));
        }
        text += &format!(
            "\n{}\n\n{}\n",
            self.vector("C(q)", "C", &e.constraints),
            self.matrix("C_q", &e.constraint_jacobian)
        );
        text += "\nThe second derivatives that are not zero:\n\n";
        for (k, hessian) in e.constraint_hessians.iter().enumerate() {
            for (i, row) in hessian.iter().enumerate() {
                for (j, entry) in row.iter().enumerate().take(i + 1).filter(|(_, entry)| !entry.is_zero()) {
                    let [a, b] = [i, j].map(|i| self.symbol(Symbol::Coordinate(i)));
                    let by =
                        if i == j { format!(r"\partial {a}^{{2}}") } else { format!(r"\partial {a}\,\partial {b}") };
                    text += &format!(
                        "$$\\frac{{\\partial^{{2}} C_{{{}}}}}{{{by}}} = {}$$\n\n",
                        k + 1,
                        self.writer.term(entry)
                    );
                }
            }
        }
        text += "They enter the motion through their contraction with the rates alone:\n\n";
        text += &self.vector(r"(C_q\,\dot q)_q\,\dot q", "c", &e.constraint_bias);
        text + "\n"
    }

    fn motion(&self) -> String {
        if self.scene.constraints.is_empty() {
            return String::from("## Equations of motion: `dynamics`\n\n$$\\bar M\\,\\ddot q = \\bar f$$\n");
        }
        format!(
            "## Equations of motion: `dynamics`, `closure`\n\n$$\\begin{{pmatrix}} \\bar M & C_q^{{T}} \\\\ C_q & 0 \
             \\end{{pmatrix}} \\begin{{pmatrix}} \\ddot q \\\\ \\lambda \\end{{pmatrix}} = \\begin{{pmatrix}} \\bar f \\\\ \
             -(C_q\\,\\dot q)_q\\,\\dot q \\end{{pmatrix}}, \\qquad \\lambda = {}$$\n\nThe force of a constraint on a point $P$ \
             is $-\\lambda\\,\\partial C/\\partial P$, the coordinates of other points and all angles held. After each step \
             positions are put back onto $C(q) = 0$, rates onto $C_q\\,\\dot q = 0$.\n",
            self.column(Symbol::Multiplier)
        )
    }

    fn outputs(&self) -> String {
        if self.scene.outputs.is_empty() {
            return String::new();
        }
        let mut text = String::from("## Outputs: `outputs`\n\n");
        for (output, term) in self.scene.outputs.iter().zip(&self.equations.outputs) {
            let what = [&output.doc, &output.unit].map(|s| s.as_str()).into_iter().filter(|s| !s.is_empty());
            let what: Vec<&str> = what.collect();
            text += &format!("`{}`, {}:\n\n$${}$$\n\n", output.name, what.join(", in "), self.writer.term(term));
        }
        text
    }

    fn left_out(&self) -> String {
        let mut text = String::from("## Left out\n\n");
        for (i, parameter) in self.scene.parameters.iter().enumerate().filter(|(_, p)| p.left_out) {
            let symbol = self.symbol(Symbol::Parameter(i));
            text += &format!(
                "- ${symbol}$ (`{}`), with everything it multiplies: exactly zero in the scene\n",
                parameter.name
            );
        }
        for reason in &self.equations.left_out {
            text += &format!("- {reason}\n");
        }
        if self.scene.left_out().next().is_none() && self.equations.left_out.is_empty() { String::new() } else { text }
    }

    /// What a row of x is.
    fn row(&self, row: &Row) -> String {
        format!("{} of `{}`", ["$x$", "$y$", "angle"][row.axis], self.scene.bodies[row.body].name)
    }

    fn symbol(&self, symbol: Symbol) -> String {
        self.writer.symbol(symbol)
    }

    fn terms(&self, terms: &[Term]) -> Vec<String> {
        terms.iter().map(|term| self.writer.term(term)).collect()
    }

    fn column(&self, symbol: fn(usize) -> Symbol) -> String {
        let count = match symbol(0) {
            Symbol::Multiplier(_) => self.scene.constraints.len(),
            _ => self.scene.coordinates.len(),
        };
        vector(&(0..count).map(|i| self.symbol(symbol(i))).collect::<Vec<_>>())
    }

    /// `name = vector`, or its entries one by one if that is too much for a page's width.
    fn vector(&self, name: &str, letter: &str, terms: &[Term]) -> String {
        let rows: Vec<Vec<Term>> = terms.iter().map(|term| vec![term.clone()]).collect();
        self.array(name, letter, &rows)
    }

    fn matrix(&self, name: &str, terms: &[Vec<Term>]) -> String {
        self.array(name, name, terms)
    }

    fn array(&self, name: &str, letter: &str, terms: &[Vec<Term>]) -> String {
        let rows: Vec<Vec<String>> = terms.iter().map(|row| self.terms(row)).collect();
        if matrix::fits(&rows) {
            return format!("$${name} = {}$$", matrix(&rows));
        }
        let summands = |row: &Vec<Term>| row.iter().map(|term| self.writer.summands(term)).collect();
        entries(name, letter, &terms.iter().map(summands).collect::<Vec<Vec<Vec<String>>>>())
    }

    fn equation(&self, name: &str, term: &Term) -> String {
        equation(name, &self.writer.summands(term))
    }
}

/// Text inside a table.
fn cell(text: &str) -> String {
    text.replace('|', r"\|")
}
