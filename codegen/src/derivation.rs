//! The derivation of a scene's equations of motion in Markdown with LaTeX, in the notation of textbooks.

mod loops;
mod matrix;
mod notation;

use crate::formula::{Style, Writer};
use crate::term::{Equations, Row, Symbol, Term};
use matrix::{entries, equation, formula, matrix, vector};
use notation::{plain, set};
use qrm_language::source_excerpts::SourceExcerpts;
use qrm_scene::scene::Scene;

/// Writes the complete derivation.
pub fn markdown(scene: &Scene, equations: &Equations, source: &str) -> String {
    let writer = Writer::new(scene, Style::Latex, &equations.names).naming_roots(equations.terms());
    let derivation = Derivation { scene, equations, words: SourceExcerpts { source }, writer };
    let sections = [
        derivation.beginning(),
        derivation.coordinates(),
        derivation.points(),
        derivation.names(),
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
    words: SourceExcerpts<'a>,
    writer: Writer<'a>,
}

impl Derivation<'_> {
    fn beginning(&self) -> String {
        let Scene { name, doc, .. } = self.scene;
        let doc = if doc.is_empty() { String::new() } else { format!("{}\n\n", plain(doc)) };
        format!(
            "# {name}: the equations of motion\n\n{doc}Derived from `scenes/{name}.toml` by the TMT method: the \
             positions of the bodies are differentiated by the generalized coordinates, loops are cut and closed by \
             constraints with multipliers. These are the formulae behind the generated functions, whose names stand \
             beside them.\n"
        )
    }

    fn coordinates(&self) -> String {
        let q = set("@q");
        let mut text = format!("## Coordinates and parameters\n\n$${q} = {}$$\n\n", self.column(Symbol::Coordinate));
        text += "| symbol | name | unit | what |\n|---|---|---|---|\n";
        for (i, c) in self.scene.coordinates.iter().enumerate() {
            text += &format!(
                "| ${}$ | `{}` | {} | {} |\n",
                self.symbol(Symbol::Coordinate(i)),
                c.name,
                plain(&c.unit),
                plain(&c.doc)
            );
        }
        if !self.scene.parameters.is_empty() {
            text += "\n| symbol | name | value | unit | what |\n|---|---|---|---|---|\n";
        }
        for (i, p) in self.scene.parameters.iter().enumerate() {
            let zero = if p.left_out { ", left out" } else { "" };
            let symbol = self.symbol(Symbol::Parameter(i));
            text += &format!(
                "| ${symbol}$ | `{}` | `{}`{zero} | {} | {} |\n",
                p.name,
                p.text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', r"\|"),
                plain(&p.unit),
                plain(&p.doc)
            );
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

    /// Writes the named quantities with their derivatives.
    fn names(&self) -> String {
        let names = &self.equations.names;
        if names.is_empty() {
            return String::new();
        }
        let mut text = String::from(
            "## Named quantities\n\nArguments, points and positions of bodies that depend on several coordinates stand \
             under a name in other formulae, and so do their derivatives. A ring marks what a second rate has beside \
             the accelerations.\n",
        );
        for (symbol, term) in names.iter().enumerate().flat_map(|(k, named)| named.definitions(k)) {
            text += &format!("\n{}\n", self.equation(&self.symbol(symbol), &term));
        }
        text
    }

    fn roots(&self) -> String {
        let roots = self.writer.roots();
        let lines = roots.iter().map(|(name, root)| format!("$${name} = {root}$$\n")).collect::<Vec<_>>().join("\n");
        if roots.is_empty() { lines } else { format!("For short:\n\n{lines}") }
    }

    fn bodies(&self) -> String {
        let mut text = set(
            "## Bodies: `com_positions`\n\n$@x(@q)$ stacks the positions of the centres of mass and the angles of the \
             bodies, as far as they carry inertia and move:\n\n| row | what | $@x_i$ | $@M_{ii}$ \
             |\n|---|---|---|---|\n",
        );
        for (i, (row, x)) in self.equations.rows.iter().zip(&self.equations.com_positions).enumerate() {
            let (what, x, inertia) = (self.row(row), self.writer.term(x), self.writer.term(&row.inertia));
            text += &format!("| {} | {what} | ${x}$ | ${inertia}$ |\n", i + 1);
        }
        text
    }

    fn jacobian(&self) -> String {
        let e = self.equations;
        let (title, quantity) = if e.has_momenta() {
            let velocities = self.vector(&set(r"@T\,@qd"), r"\mathcal{V}", &e.com_velocities);
            ("Velocities and convective accelerations: `com_velocities`, `com_bias`", velocities)
        } else {
            let matrix = self.matrix(&set("@T"), &e.com_jacobian);
            ("Transformation matrix and convective accelerations: `com_jacobian`, `com_bias`", matrix)
        };
        let definition = set(r"$$@xd = @T\,@qd, \qquad @T = \frac{\partial @x}{\partial @q}$$");
        let second_rate = set(r"$$@xdd = @T\,@qdd + (@T\,@qd)_{@q}\,@qd$$");
        let bias = self.vector(&set(r"(@T\,@qd)_{@q}\,@qd"), r"\mathcal{B}", &e.com_bias);
        format!("## {title}\n\n{definition}\n\n{quantity}\n\n{second_rate}\n\n{bias}\n")
    }

    fn mass(&self) -> String {
        if self.equations.has_momenta() {
            let text = "Each body has momenta along the named quantities in its position. From the last quantity to \
                        the first, the momentum along a quantity, times its derivatives, is added to the momenta \
                        along the quantities in its definition. Momenta along the coordinates remain. Unit rates give \
                        the columns of the matrix.\n";
            return format!(
                "## Generalized momenta: `momenta`\n\n{}\n\n{text}",
                set(r"$$@m\,@qd = @T^{T} @M\,@T\,@qd$$")
            );
        }
        let matrix = self.matrix(&set("@m"), &self.equations.mass_matrix);
        format!("## Reduced mass matrix: `mass_matrix`\n\n{}\n\n{matrix}\n", set(r"$$@m = @T^{T} @M\,@T$$"))
    }

    fn loads(&self) -> String {
        let mut text = String::from("## Loads and reduced forces: `generalized_forces`, `energy`, `power`\n\n");
        for load in &self.scene.loads {
            text += &format!("- `{}`: {}\n", load.name, self.words.load(&load.kind));
        }
        if self.scene.loads.is_empty() {
            text += "There are no loads.\n";
        }
        text += &set("\n$$@f = @Q + @T^{T}\\left(@F - @M\\,(@T\\,@qd)_{@q}\\,@qd\\right)$$\n\n");
        if self.equations.has_momenta() {
            text += "The forces along named quantities are those along the quantities in their definitions, times the \
                     derivatives: this leads to the forces along the coordinates.\n";
        } else {
            text += &self.vector(&set("@f"), &set("@f"), &self.equations.generalized_forces);
        }
        let [kinetic, potential] = [0, 1].map(|i| &self.equations.energy[i]);
        text += &format!(
            "\n\nKinetic energy, and the potential of the loads that have one:\n\n{}\n\n{}\n",
            self.equation(r"E_{\mathrm{kin}}", kinetic),
            self.equation(r"E_{\mathrm{pot}}", potential)
        );
        if !self.equations.power[0].is_zero() {
            let driving = if self.scene.is_driven() { ", and of what moves the loops" } else { "" };
            text += &format!(
                "\nPower of the others{driving}:\n\n{}\n",
                self.equation(r"\dot{W}", &self.equations.power[0])
            );
        }
        text
    }

    fn outputs(&self) -> String {
        if self.scene.outputs.is_empty() {
            return String::new();
        }
        let mut text = String::from("## Outputs: `outputs`\n\n");
        for (output, term) in self.scene.outputs.iter().zip(&self.equations.outputs) {
            let doc = if output.doc.is_empty() { String::new() } else { format!(", {}", plain(&output.doc)) };
            let unit = if output.unit.is_empty() { String::new() } else { format!(", in {}", plain(&output.unit)) };
            let summands = self.writer.summands(term);
            text += &format!("`{}`{doc}{unit}:\n\n{}\n\n", output.name, formula(&summands));
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

    /// The name of a row of x, that is, of a coordinate of a body.
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

    /// Writes `name = vector`, or entry by entry if that is too wide for a page.
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
