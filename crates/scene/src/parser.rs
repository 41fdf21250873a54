//! Parses tokens into an [`Expression`] with the usual precedences; `^` is right-associative and binds tighter than a
//! sign before it.

use std::sync::Arc;

use crate::declarations::{Declarations, LookupTable};
use crate::diagnostic::{Diagnostic, Span};
use crate::dimension::{Dimension, Dimensions, Source};
use crate::expression::{Expression, Node, NodeId, Number};
use crate::function::Function;
use crate::lexer::{Comparison, Token, tokenize};
use crate::names::suggestion;
use crate::unit::{Unit, unknown_unit};

/// The largest nesting depth of parentheses, signs and powers.
const DEPTH_LIMIT: usize = 200;

/// The largest number of numbers, names and operations in a formula. The memory for the text of its code grows with the
/// square of that: 200 MB at this limit.
pub(crate) const OPERATION_LIMIT: usize = 4000;

/// A formula whose names are still text.
pub type Formula = Expression<String>;

/// A condition `left >= right` or `left <= right`; it becomes true when `left - right` rises or falls through zero.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Condition<N> {
    /// Left-hand side minus right-hand side.
    pub difference: Expression<N>,
    /// How the two sides are compared.
    pub comparison: Comparison,
}

/// The error is boxed, so that the recursion needs little stack: one level of nesting passes through five functions.
type Parsed<T> = Result<T, Box<Diagnostic>>;

/// Reads a formula that begins at byte `offset` of its file.
///
/// # Errors
/// The first error in the formula, with its location.
pub fn parse_formula(text: &str, offset: usize, declarations: &Declarations) -> Result<Formula, Diagnostic> {
    parse_quantity(text, offset, declarations, None).map(|(formula, _)| formula)
}

/// Reads a formula like [`parse_formula`], and its dimension. `unit` is the unit to which the result will be converted.
///
/// # Errors
/// The first error in the formula, with its location.
pub fn parse_quantity(
    text: &str,
    offset: usize,
    declarations: &Declarations,
    unit: Option<&Unit>,
) -> Result<(Formula, Dimension), Diagnostic> {
    let mut parser = Parser::new(text, offset, declarations)?;
    let unit = unit.filter(|unit| unit.is_scaled());
    parser.is_converted = unit.is_some();
    parser.sum().and_then(|_| parser.expect_end()).map_err(|error| *error)?;
    if let Some(error) = unit.and_then(|unit| parser.dimensions.conversion(&parser.formula, unit)) {
        return Err(error);
    }
    let dimension = parser.dimensions.whole();
    Ok((parser.finish()?, dimension))
}

/// Reads a condition that begins at byte `offset` of its file.
///
/// # Errors
/// The first error in the condition, with its location.
pub fn parse_condition(
    text: &str,
    offset: usize,
    declarations: &Declarations,
) -> Result<Condition<String>, Diagnostic> {
    let mut parser = Parser::new(text, offset, declarations)?;
    let (left, comparison, right) = parser.condition().map_err(|error| *error)?;
    parser.push(Node::Subtract(left, right), offset..offset + text.len()).map_err(|error| *error)?;
    if let Some(ambiguity) = parser.dimensions.whole().ambiguity {
        return Err(*ambiguity);
    }
    Ok(Condition { difference: parser.finish()?, comparison })
}

struct Parser<'c> {
    declarations: &'c Declarations,
    text: &'c str,
    /// The byte of the file at which the text begins.
    offset: usize,
    tokens: Vec<(Token, Span)>,
    at: usize,
    end: usize,
    depth: usize,
    /// Whether the result will be converted: the units of all names count then.
    is_converted: bool,
    formula: Formula,
    dimensions: Dimensions,
}

impl<'c> Parser<'c> {
    fn new(text: &'c str, offset: usize, declarations: &'c Declarations) -> Result<Self, Diagnostic> {
        if text.trim().is_empty() {
            return Err(Diagnostic::error("empty formula", offset..offset + text.len(), "nothing here")
                .help("write a formula, or `0`"));
        }
        let tokens = tokenize(text, offset)?;
        let end = offset + text.trim_end().len();
        let (formula, dimensions) = (Formula::new(), Dimensions::default());
        Ok(Self { declarations, text, offset, tokens, at: 0, end, depth: 0, is_converted: false, formula, dimensions })
    }

    /// Appends an operation, and derives its dimension.
    fn push(&mut self, node: Node<String>, span: Span) -> Parsed<NodeId> {
        let id = self.formula.push(node, span);
        self.dimensions.derive(&self.formula)?;
        Ok(id)
    }

    fn finish(self) -> Result<Formula, Diagnostic> {
        let length = self.formula.nodes().len();
        if length <= OPERATION_LIMIT {
            return Ok(self.formula);
        }
        let label = format!("{length} numbers, names and operations");
        let help = format!("up to {OPERATION_LIMIT} are read; name parts of it as points or parameters");
        Err(Diagnostic::error("a formula is too long", self.formula.whole_span(), label).help(help))
    }

    fn peek(&self) -> Option<&(Token, Span)> {
        self.tokens.get(self.at)
    }

    /// The location of the next token, or the end of the formula.
    fn here(&self) -> Span {
        self.peek().map_or(self.end..self.end, |(_, span)| span.clone())
    }

    /// Takes the next token if it is one of these symbols.
    fn take(&mut self, symbols: &[char]) -> Option<(char, Span)> {
        match self.peek() {
            Some((Token::Symbol(symbol), span)) if symbols.contains(symbol) => {
                let taken = (*symbol, span.clone());
                self.at += 1;
                Some(taken)
            }
            _ => None,
        }
    }

    fn condition(&mut self) -> Parsed<(NodeId, Comparison, NodeId)> {
        let left = self.sum()?;
        let Some((Token::Comparison(comparison), _)) = self.peek().cloned() else {
            // A token that no formula can contain here is reported first.
            self.expect_end()?;
            let error = Diagnostic::error("a comparison is missing", self.here(), "expected `>=` or `<=` here");
            return Err(Box::new(error.help("write a condition such as `phi2 >= 4*pi`")));
        };
        self.at += 1;
        let right = self.sum()?;
        self.expect_end()?;
        Ok((left, comparison, right))
    }

    fn expect_end(&self) -> Parsed<()> {
        let Some((token, span)) = self.peek() else { return Ok(()) };
        let (title, label, help) = match token {
            Token::Symbol(')') => {
                ("unmatched `)`", "closes no parenthesis", "take it out, or add the `(` that belongs to it")
            }
            Token::Symbol(',') => (
                "unexpected `,`",
                "separates nothing here",
                "commas separate arguments, as in `hypot(x, y)`; decimals have a point",
            ),
            Token::Comparison(_) => (
                "a comparison is not a value",
                "unexpected here",
                "only the stop condition `until` compares: once, and outside of all parentheses",
            ),
            Token::Name(name)
                if self.is_behind_number() && !name.contains('.') && !self.declarations.contains(name) =>
            {
                return Err(Box::new(unknown_unit(name, span.clone())));
            }
            _ => ("an operator is missing", "expected an operator before this", "products need an explicit `*`"),
        };
        Err(Box::new(Diagnostic::error(title, span.clone(), label).help(help)))
    }

    /// Whether the token before the next one is a number.
    fn is_behind_number(&self) -> bool {
        self.at > 0 && matches!(self.tokens[self.at - 1].0, Token::Number(_))
    }

    fn binary(&mut self, node: Node<String>, left: NodeId, right: NodeId) -> Parsed<NodeId> {
        let span = self.formula.span(left).start..self.formula.span(right).end;
        self.push(node, span)
    }

    fn sum(&mut self) -> Parsed<NodeId> {
        let mut left = self.product()?;
        while let Some((symbol, _)) = self.take(&['+', '-']) {
            let right = self.product()?;
            let node = if symbol == '+' { Node::Add(left, right) } else { Node::Subtract(left, right) };
            left = self.binary(node, left, right)?;
        }
        Ok(left)
    }

    fn product(&mut self) -> Parsed<NodeId> {
        let mut left = self.signed()?;
        let mut is_product = false;
        while let Some((symbol, _)) = self.take(&['*', '/']) {
            let right = self.signed()?;
            let node = if symbol == '*' { Node::Multiply(left, right) } else { Node::Divide(left, right) };
            left = self.binary(node, left, right)?;
            is_product = true;
        }
        let error = self.dimensions.double_conversion(&self.formula, left).filter(|_| is_product);
        error.map_or(Ok(left), |error| Err(Box::new(error)))
    }

    /// Parses a value with any signs before it. Every cycle of the grammar passes here, so the depth is checked here.
    fn signed(&mut self) -> Parsed<NodeId> {
        self.depth += 1;
        if self.depth > DEPTH_LIMIT {
            return Err(self.nested_too_deeply());
        }
        let value = match self.take(&['+', '-']) {
            Some(('-', span)) => {
                let operand = self.signed()?;
                let span = span.start..self.formula.span(operand).end;
                self.push(Node::Negate(operand), span)?
            }
            Some(_) => self.signed()?,
            None => self.power()?,
        };
        self.depth -= 1;
        Ok(value)
    }

    fn power(&mut self) -> Parsed<NodeId> {
        let base = self.atom()?;
        if self.take(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.signed()?;
        self.binary(Node::Power(base, exponent), base, exponent)
    }

    fn atom(&mut self) -> Parsed<NodeId> {
        let Some((token, span)) = self.peek().cloned() else { return Err(self.value_missing()) };
        match token {
            Token::Number(number) => {
                self.at += 1;
                self.quantity(number, span)
            }
            Token::Name(name) => {
                self.at += 1;
                if self.take(&['(']).is_some() { self.call(&name, span) } else { self.name(name, span) }
            }
            Token::Symbol('(') => {
                self.at += 1;
                let inner = self.sum()?;
                let closed = self.close(&span)?;
                self.formula.set_span(inner, span.start..closed.end);
                Ok(inner)
            }
            _ => Err(self.value_missing()),
        }
    }

    /// Appends a number, converted to SI units if a unit follows: `25 mm`, `9.81 m/s^2`, `0.2 kg m^2`.
    fn quantity(&mut self, number: Number, span: Span) -> Parsed<NodeId> {
        let first = self.at;
        let Some(unit_span) = self.unit()? else { return self.push(Node::Number(number), span) };
        let text = &self.text[unit_span.start - self.offset..unit_span.end - self.offset];
        let Some(unit) = Unit::parse(text) else { return Err(Box::new(unknown_unit(text, unit_span))) };
        let whole = span.start..unit_span.end;
        let id = match unit.number(&number) {
            Some(converted) => self.formula.push(Node::Number(converted), whole),
            None => {
                let number = self.formula.push(Node::Number(number), span);
                let id = unit.append(&mut self.formula, number, &unit_span);
                self.formula.set_span(id, whole);
                id
            }
        };
        let ambiguity = self.tokens[first..self.at].iter().find_map(|(token, span)| self.ambiguity(token, span));
        let (unit, source) = (Some(unit), Source::Number);
        self.dimensions.note(&self.formula, Dimension { unit, source, ambiguity, ..Dimension::default() });
        Ok(id)
    }

    /// An error about a unit that is also a name of the scene.
    fn ambiguity(&self, token: &Token, span: &Span) -> Option<Box<Diagnostic>> {
        let Token::Name(name) = token else { return None };
        if !self.declarations.contains(name) {
            return None;
        }
        let title = format!("`{name}` is a name of this scene, and a unit");
        let help = format!("write `*{name}` or `/({name})` for the name; for the unit, give the number in another one");
        Some(Box::new(Diagnostic::error(title, span.clone(), "which of them?").help(help)))
    }

    /// Takes the unit of a number, if there is one: names of units, with powers, behind one another or divided.
    fn unit(&mut self) -> Parsed<Option<Span>> {
        let mut span: Option<Span> = None;
        loop {
            let symbol = |parser: &Self, at: usize| match parser.tokens.get(at) {
                Some((Token::Symbol(symbol), _)) => Some(*symbol),
                _ => None,
            };
            let is_divided = span.is_some() && symbol(self, self.at) == Some('/');
            if is_divided && symbol(self, self.at + 1) == Some('(') {
                let Some(end) = self.group_of_units(self.at + 2) else { return Ok(span) };
                let start = span.map_or(end, |span| span.start);
                (self.at, span) = (end + 1, Some(start..self.tokens[end].1.end));
                continue;
            }
            let place = self.at + usize::from(is_divided);
            let Some((Token::Name(name), own)) = self.tokens.get(place) else { return Ok(span) };
            if symbol(self, place + 1) == Some('(') || !Unit::is_known(name) {
                return Ok(span);
            }
            let mut end = own.end;
            let start = span.map_or(own.start, |span| span.start);
            self.at = place + 1;
            if self.take(&['^']).is_some() {
                self.take(&['-']);
                let Some((Token::Number(_), exponent)) = self.peek() else { return Err(self.value_missing()) };
                end = exponent.end;
                self.at += 1;
            }
            span = Some(start..end);
        }
    }

    /// The place of the `)` behind a product or quotient of units that begins at a token.
    fn group_of_units(&self, begin: usize) -> Option<usize> {
        let count = self.tokens[begin..].iter().position(|(token, _)| *token == Token::Symbol(')'))?;
        let is_part = |(token, _): &(Token, Span)| match token {
            Token::Name(name) => Unit::is_known(name),
            Token::Number(_) => true,
            Token::Symbol(symbol) => matches!(symbol, '/' | '^' | '*' | '-'),
            Token::Comparison(_) => false,
        };
        let parts = &self.tokens[begin..begin + count];
        (matches!(parts.first(), Some((Token::Name(_), _))) && parts.iter().all(is_part)).then_some(begin + count)
    }

    fn name(&mut self, name: String, span: Span) -> Parsed<NodeId> {
        if Function::named(&name).is_some() || self.declarations.tables.iter().any(|table| table.spline.name == name) {
            let error = Diagnostic::error(format!("`{name}` is a function"), span, "its argument is missing");
            return Err(Box::new(error.help(format!("write `{name}(...)`"))));
        }
        let is_bare = name == "pi";
        let unit = if is_bare { Some(Unit::one()) } else { self.declarations.unit(&name) };
        let source = match unit {
            Some(_) if self.is_converted && !is_bare => Source::Conversion,
            _ => self.declarations.source(&name),
        };
        let mut id = self.formula.push(Node::Name(name), span.clone());
        if let Some(unit) = unit.as_ref().filter(|unit| unit.is_scaled()) {
            self.dimensions.note(&self.formula, Dimension::default());
            id = unit.append(&mut self.formula, id, &span);
        }
        self.dimensions.note(&self.formula, Dimension { unit, source, is_bare, has_pi: is_bare, ambiguity: None });
        Ok(id)
    }

    fn call(&mut self, name: &str, name_span: Span) -> Parsed<NodeId> {
        let opened = name_span.end..name_span.end + 1;
        let mut arguments = Vec::new();
        if !matches!(self.peek(), Some((Token::Symbol(')'), _))) {
            arguments.push(self.sum()?);
            while self.take(&[',']).is_some() {
                arguments.push(self.sum()?);
            }
        }
        let closed = self.close(&opened)?;
        let span = name_span.start..closed.end;
        let table = self.declarations.tables.iter().find(|table| table.spline.name == name);
        if let (Some(table), None) = (table, Function::named(name)) {
            let [argument] = arguments[..] else { return Err(wrong_arity(name, 1, arguments.len(), span)) };
            return self.look_up(table, argument, &span);
        }
        let function =
            Function::named(name).ok_or_else(|| unknown_function(name, self.declarations, name_span.clone()))?;
        if arguments.len() != function.arity() {
            return Err(wrong_arity(name, function.arity(), arguments.len(), span));
        }
        self.push(Node::Call(function, arguments), span)
    }

    /// Appends the value of a table.
    fn look_up(&mut self, table: &LookupTable, argument: NodeId, span: &Span) -> Parsed<NodeId> {
        let node = Node::Spline(Arc::clone(&table.spline), argument);
        let [abscissa, ordinate] = &table.dimensions;
        let mut sum = match abscissa.as_ref().and_then(|own| own.unit.as_ref()) {
            None => self.push(node, span.clone())?,
            Some(unit) => {
                if let Some(error) = self.dimensions.of(argument).misfit(unit, self.formula.span(argument)) {
                    return Err(Box::new(error));
                }
                let id = self.formula.push(node, span.clone());
                self.dimensions.note(&self.formula, Dimension::bare());
                id
            }
        };
        let added: usize = table.parts.iter().map(|(ordinate, _)| ordinate.nodes().len() + 3).sum();
        if self.formula.nodes().len() + added > OPERATION_LIMIT {
            let label = format!("{added} numbers, names and operations in its entries");
            let error = Diagnostic::error("a formula is too long", span.clone(), label);
            return Err(Box::new(error.help("call the table in a point, or give it fewer formulae")));
        }
        for (ordinate, cardinal) in &table.parts {
            // Spans of ordinates lie in the table.
            let ordinate = self.formula.append(ordinate);
            let cardinal = self.formula.push(Node::Spline(Arc::clone(cardinal), argument), span.clone());
            let product = self.formula.push(Node::Multiply(ordinate, cardinal), span.clone());
            sum = self.formula.push(Node::Add(sum, product), span.clone());
        }
        if ordinate.is_some() || !table.parts.is_empty() {
            self.dimensions.note(&self.formula, ordinate.clone().unwrap_or_default());
        }
        Ok(sum)
    }

    /// Takes the `)` that belongs to the `(` at `opened`.
    fn close(&mut self, opened: &Span) -> Parsed<Span> {
        if let Some((_, span)) = self.take(&[')']) {
            return Ok(span);
        }
        self.expect_end()?;
        let error = Diagnostic::error("unclosed parenthesis", opened.clone(), "opened here, never closed");
        Err(Box::new(error.help("add the `)` that belongs to it")))
    }

    fn value_missing(&self) -> Box<Diagnostic> {
        let title = if self.peek().is_some() { "a value is missing" } else { "the formula ends too early" };
        let error = Diagnostic::error(title, self.here(), "expected a number, a name or `(` here");
        Box::new(error.help("every operator needs a value on both sides, every call its arguments"))
    }

    fn nested_too_deeply(&self) -> Box<Diagnostic> {
        let error = Diagnostic::error("formula nested too deeply", self.here(), "one level too many");
        let help = format!("up to {DEPTH_LIMIT} levels are read; name a part of it as a point or a parameter");
        Box::new(error.help(help))
    }
}

fn unknown_function(name: &str, declarations: &Declarations, span: Span) -> Box<Diagnostic> {
    if declarations.tables_of_parameters.contains(name) {
        let title = format!("table `{name}` has formulae as entries");
        let error = Diagnostic::error(title, span, "a parameter cannot call it");
        return Box::new(error.help("call it where the value is needed, or give the table numbers"));
    }
    let own = declarations.tables.iter().map(|table| table.spline.name.as_str());
    let known: Vec<&str> = Function::ALL.iter().map(|f| f.name()).chain(own).collect();
    let help = suggestion(name, known.iter().copied(), || format!("known functions: {}", known.join(", ")));
    Box::new(Diagnostic::error(format!("unknown function `{name}`"), span, "not known").help(help))
}

fn wrong_arity(name: &str, arity: usize, given: usize, span: Span) -> Box<Diagnostic> {
    let (arguments, plural) = if arity == 1 { ("a", "") } else { ("a, b", "s") };
    let title = format!("`{name}` takes {arity} argument{plural}");
    let label = if given == 1 { "1 is given".to_owned() } else { format!("{given} are given") };
    Box::new(Diagnostic::error(title, span, label).help(format!("write `{name}({arguments})`")))
}
