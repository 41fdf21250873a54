//! Tokens to [`Expression`]: the usual precedences, `^` binding tighter than a sign before it and to the right.

use crate::diagnostic::{Diagnostic, Span};
use crate::expression::{Expression, Node, NodeId};
use crate::function::Function;
use crate::lexer::{Comparison, Token, tokenize};
use crate::names::closest;

/// How deep parentheses, signs and powers may nest.
const DEPTH_LIMIT: usize = 200;

/// A formula whose names are still text.
pub type Formula = Expression<String>;

/// A condition `left >= right` and its kind; it becomes true when `left - right` rises through zero, or falls.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition<N> {
    /// Left-hand side minus right-hand side.
    pub difference: Expression<N>,
    /// How the two sides are compared.
    pub comparison: Comparison,
}

/// Reads a formula that begins at byte `offset` of its file.
///
/// # Errors
/// The first mistake in the formula, with its place.
pub fn parse_formula(text: &str, offset: usize) -> Result<Formula, Diagnostic> {
    let mut parser = Parser::new(text, offset)?;
    parser.sum()?;
    parser.expect_end()?;
    Ok(parser.formula)
}

/// Reads a condition that begins at byte `offset` of its file.
///
/// # Errors
/// The first mistake in the condition, with its place.
pub fn parse_condition(text: &str, offset: usize) -> Result<Condition<String>, Diagnostic> {
    let mut parser = Parser::new(text, offset)?;
    let left = parser.sum()?;
    let Some((Token::Comparison(comparison), _)) = parser.peek().cloned() else {
        return Err(Diagnostic::error("a condition is missing", parser.here(), "expected `>=` or `<=` here")
            .help("write a condition such as `phi2 >= 4*pi`"));
    };
    parser.at += 1;
    let right = parser.sum()?;
    parser.expect_end()?;
    parser.formula.push(Node::Subtract(left, right), offset..offset + text.len());
    Ok(Condition { difference: parser.formula, comparison })
}

struct Parser {
    tokens: Vec<(Token, Span)>,
    at: usize,
    end: usize,
    depth: usize,
    formula: Formula,
}

impl Parser {
    fn new(text: &str, offset: usize) -> Result<Self, Diagnostic> {
        if text.trim().is_empty() {
            return Err(Diagnostic::error("empty formula", offset..offset + text.len(), "nothing here")
                .help("write a formula, or `0`"));
        }
        let tokens = tokenize(text, offset)?;
        let end = offset + text.trim_end().len();
        Ok(Self { tokens, at: 0, end, depth: 0, formula: Formula::new() })
    }

    fn peek(&self) -> Option<&(Token, Span)> {
        self.tokens.get(self.at)
    }

    /// The place of the next token, or the end of the formula.
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

    fn expect_end(&self) -> Result<(), Diagnostic> {
        match self.peek() {
            None => Ok(()),
            Some((Token::Symbol(')'), span)) => {
                Err(Diagnostic::error("unmatched `)`", span.clone(), "closes no parenthesis"))
            }
            Some((Token::Comparison(_), span)) => {
                Err(Diagnostic::error("a comparison is not a value", span.clone(), "unexpected here")
                    .help("comparisons belong into the stop condition `until` alone"))
            }
            Some((_, span)) => Err(Diagnostic::error("an operator is missing", span.clone(), "expected an operator before this")
                .help("products need an explicit `*`")),
        }
    }

    fn binary(&mut self, node: Node<String>, left: NodeId, right: NodeId) -> NodeId {
        let span = self.formula.span(left).start..self.formula.span(right).end;
        self.formula.push(node, span)
    }

    fn sum(&mut self) -> Result<NodeId, Diagnostic> {
        let mut left = self.product()?;
        while let Some((symbol, _)) = self.take(&['+', '-']) {
            let right = self.product()?;
            let node = if symbol == '+' { Node::Add(left, right) } else { Node::Subtract(left, right) };
            left = self.binary(node, left, right);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<NodeId, Diagnostic> {
        let mut left = self.signed()?;
        while let Some((symbol, _)) = self.take(&['*', '/']) {
            let right = self.signed()?;
            let node = if symbol == '*' { Node::Multiply(left, right) } else { Node::Divide(left, right) };
            left = self.binary(node, left, right);
        }
        Ok(left)
    }

    /// A value with any signs before it. Every cycle of the grammar passes here, so here its depth is bounded.
    fn signed(&mut self) -> Result<NodeId, Diagnostic> {
        self.depth += 1;
        if self.depth > DEPTH_LIMIT {
            return Err(Diagnostic::error("formula nested too deeply", self.here(), "one level too many")
                .help(format!("up to {DEPTH_LIMIT} levels are read; name a part of it as a point or a parameter")));
        }
        let value = match self.take(&['+', '-']) {
            Some(('-', span)) => {
                let operand = self.signed()?;
                let span = span.start..self.formula.span(operand).end;
                self.formula.push(Node::Negate(operand), span)
            }
            Some(_) => self.signed()?,
            None => self.power()?,
        };
        self.depth -= 1;
        Ok(value)
    }

    fn power(&mut self) -> Result<NodeId, Diagnostic> {
        let base = self.atom()?;
        if self.take(&['^']).is_none() {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(self.binary(Node::Power(base, exponent), base, exponent))
    }

    fn atom(&mut self) -> Result<NodeId, Diagnostic> {
        let Some((token, span)) = self.peek().cloned() else {
            return Err(Diagnostic::error("the formula ends too early", self.here(), "expected a value here"));
        };
        self.at += 1;
        match token {
            Token::Number(number) => Ok(self.formula.push(Node::Number(number), span)),
            Token::Name(name) => {
                if self.take(&['(']).is_some() {
                    return self.call(&name, span);
                }
                if Function::named(&name).is_some() {
                    return Err(Diagnostic::error(
                        format!("`{name}` is a function"),
                        span.clone(),
                        "its argument is missing",
                    )
                    .help(format!("write `{name}(...)`")));
                }
                Ok(self.formula.push(Node::Name(name), span))
            }
            Token::Symbol('(') => {
                let inner = self.sum()?;
                self.close(&span)?;
                Ok(inner)
            }
            _ => Err(Diagnostic::error("a value is missing", span, "expected a number, a name or `(` here")),
        }
    }

    fn close(&mut self, opened: &Span) -> Result<Span, Diagnostic> {
        match self.take(&[')']) {
            Some((_, span)) => Ok(span),
            None if self.peek().is_none() => {
                Err(Diagnostic::error("unclosed parenthesis", opened.clone(), "opened here, never closed"))
            }
            None => {
                let unexpected = self.expect_end().err();
                Err(unexpected.unwrap_or_else(|| Diagnostic::error("unclosed parenthesis", opened.clone(), "opened here")))
            }
        }
    }

    fn call(&mut self, name: &str, name_span: Span) -> Result<NodeId, Diagnostic> {
        let opened = name_span.end..name_span.end + 1;
        let mut arguments = Vec::new();
        if !matches!(self.peek(), Some((Token::Symbol(')'), _))) {
            arguments.push(self.sum()?);
            while self.take(&[',']).is_some() {
                arguments.push(self.sum()?);
            }
        }
        let closed = self.close(&opened)?;
        let Some(function) = Function::named(name) else {
            let known: Vec<&str> = Function::ALL.iter().map(|f| f.name()).collect();
            let error = Diagnostic::error(format!("unknown function `{name}`"), name_span, "not known");
            return Err(match closest(name, known.iter().copied()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("known functions: {}", known.join(", "))),
            });
        };
        if arguments.len() != function.arity() {
            return Err(Diagnostic::error(
                format!("`{name}` takes {} argument{}", function.arity(), if function.arity() == 1 { "" } else { "s" }),
                name_span.start..closed.end,
                format!("{} given", arguments.len()),
            ));
        }
        Ok(self.formula.push(Node::Call(function, arguments), name_span.start..closed.end))
    }
}
