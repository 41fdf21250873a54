//! Reads a printed function back.

use std::collections::HashMap;

use qrm_core::Operation;
use quote::ToTokens;
use syn::{BinOp, Block, Expr, ExprLit, Lit, Member, Pat, Stmt, UnOp};

use crate::identifier::ident;
use qrm_core::NamedTape;
use qrm_core::named_tape::{Argument, Function, ResultField, place};

/// Reads one function.
pub(super) struct Reader<'t> {
    pub(super) tape: &'t NamedTape,
    pub(super) names: HashMap<String, u32>,
}

impl Reader<'_> {
    pub(super) fn function(mut self, function: &Function, block: &Block) -> Result<(), String> {
        let Some((Stmt::Expr(result, None), statements)) = block.stmts.split_last() else {
            return Err("a function without a result".to_owned());
        };
        for argument in [Argument::Time].into_iter().filter(|time| function.arguments.contains(time)) {
            self.names.insert("t".to_owned(), self.tape.input(argument));
        }
        for statement in statements {
            let Stmt::Local(local) = statement else { return Err(unexpected(statement)) };
            let init = local.init.as_ref().ok_or_else(|| unexpected(statement))?;
            self.bind(&local.pat, &init.expr)?;
        }
        let expected: Vec<u32> = function.results().collect();
        let results = match &*function.name {
            "parameters" => (0..place(self.tape.sizes()[0])).map(|input| self.parameter(input)).collect(),
            _ => self.results(function, result)?,
        };
        match results.iter().zip(&expected).position(|(read, expected)| read != expected) {
            Some(i) => Err(format!("result {i} is another value")),
            None if results.len() != expected.len() => Err("other results".to_owned()),
            None => Ok(()),
        }
    }

    /// The printed value of a parameter, stored with its name.
    fn parameter(&self, input: u32) -> u32 {
        self.names.get(&format!("= {}", ident(&self.tape.names[&input]))).copied().unwrap_or(u32::MAX)
    }

    fn bind(&mut self, pattern: &Pat, value: &Expr) -> Result<(), String> {
        match pattern {
            Pat::Ident(name) => {
                let name = name.ident.to_string();
                if let Some(own) = default_value(value) {
                    let own = self.value(own)?;
                    self.names.insert(format!("= {name}"), own);
                    let is_this = |input: &u32| ident(&self.tape.names[input]) == name;
                    let input = (0..place(self.tape.sizes()[0])).find(is_this).ok_or_else(|| unexpected(value))?;
                    self.names.insert(name, input);
                } else if !matches!(value, Expr::Reference(_)) {
                    let value = self.value(value)?;
                    self.names.insert(name, value);
                }
                Ok(())
            }
            Pat::Tuple(pair) => {
                let sine = self.value(value)?;
                for (name, value) in pair.elems.iter().zip(sine..) {
                    self.names.insert(name.to_token_stream().to_string(), value);
                }
                Ok(())
            }
            Pat::Slice(list) => {
                let first = self.list(value)?;
                for (name, input) in list.elems.iter().zip(first..) {
                    self.names.insert(name.to_token_stream().to_string(), input);
                }
                Ok(())
            }
            Pat::Struct(_) => {
                let position = self.tape.function("position").ok_or_else(|| unexpected(value))?;
                let fields = position.parts.iter().map(|part| part.name.clone()).zip(position.results());
                self.names.extend(fields);
                Ok(())
            }
            other => Err(unexpected(other)),
        }
    }

    /// The first input of a list: `*q` or `angles.sin`.
    fn list(&self, value: &Expr) -> Result<u32, String> {
        let [_, n, _] = self.tape.sizes();
        Ok(match &*value.to_token_stream().to_string() {
            "* q" => self.tape.input(Argument::Coordinates),
            "* qd" => self.tape.input(Argument::Rates),
            "* qdd" => self.tape.input(Argument::Accelerations),
            "* multipliers" => self.tape.input(Argument::Multipliers),
            "* residuals" => self.tape.input(Argument::Residuals),
            "angles . sin" => self.tape.sine(0),
            "angles . cos" => self.tape.sine(0) + place(n),
            _ => return Err(unexpected(value)),
        })
    }

    /// The results of a function, fields in the order of its parts.
    fn results(&self, function: &Function, value: &Expr) -> Result<Vec<u32>, String> {
        match value {
            Expr::Struct(structure) => {
                let mut results = Vec::new();
                for part in &function.parts {
                    let is_this = |member: &Member| matches!(member, Member::Named(name) if *name == ident(&part.name));
                    let field = structure.fields.iter().find(|field| is_this(&field.member));
                    results.extend(self.values(&field.ok_or_else(|| unexpected(value))?.expr)?);
                }
                Ok(results)
            }
            Expr::Call(some) if some.func.to_token_stream().to_string() == "Some" => self.values(&some.args[0]),
            value => self.values(value),
        }
    }

    /// All numbers of a nested list, or a single number.
    fn values(&self, value: &Expr) -> Result<Vec<u32>, String> {
        match value {
            Expr::Array(syn::ExprArray { elems, .. }) | Expr::Tuple(syn::ExprTuple { elems, .. }) => {
                let lists: Result<Vec<Vec<u32>>, String> = elems.iter().map(|value| self.values(value)).collect();
                Ok(lists?.concat())
            }
            Expr::Block(block) => self.sparse(&block.block),
            value => Ok(vec![self.value(value)?]),
        }
    }

    /// A matrix given by its nonzero entries.
    fn sparse(&self, block: &Block) -> Result<Vec<u32>, String> {
        let mut entries = Vec::new();
        let mut width = 0;
        for statement in &block.stmts {
            match statement {
                Stmt::Local(local) => {
                    let Some(Expr::Repeat(rows)) = local.init.as_ref().map(|init| &*init.expr) else {
                        return Err(unexpected(local));
                    };
                    let Expr::Repeat(row) = &*rows.expr else { return Err(unexpected(rows)) };
                    width = index(&row.len)?;
                    entries = vec![self.value(&row.expr)?; width * index(&rows.len)?];
                }
                Stmt::Expr(Expr::Assign(assignment), _) => {
                    let Expr::Index(entry) = &*assignment.left else { return Err(unexpected(assignment)) };
                    let Expr::Index(row) = &*entry.expr else { return Err(unexpected(assignment)) };
                    let at = index(&row.index)? * width + index(&entry.index)?;
                    *entries.get_mut(at).ok_or_else(|| unexpected(assignment))? = self.value(&assignment.right)?;
                }
                _ => {}
            }
        }
        Ok(entries)
    }

    fn value(&self, value: &Expr) -> Result<u32, String> {
        let operation = match value {
            Expr::Paren(inner) => return self.value(&inner.expr),
            Expr::Path(path) => {
                let name = path.to_token_stream().to_string();
                return self.names.get(&name).copied().ok_or_else(|| format!("unknown name `{name}`"));
            }
            Expr::Field(field) => return self.field(field),
            Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => match literal(&unary.expr) {
                Some(number) => Operation::Number(-number),
                None => Operation::Neg(self.value(&unary.expr)?),
            },
            Expr::Binary(binary) => {
                let (a, b) = (self.value(&binary.left)?, self.value(&binary.right)?);
                match binary.op {
                    BinOp::Add(_) => Operation::Add(a, b),
                    BinOp::Sub(_) => Operation::Sub(a, b),
                    BinOp::Mul(_) => Operation::Mul(a, b),
                    BinOp::Div(_) => Operation::Div(a, b),
                    _ => return Err(unexpected(value)),
                }
            }
            Expr::Call(call) if call.func.to_token_stream().to_string() == "R :: pi" => Operation::Pi,
            Expr::Call(_) => Operation::Number(literal(value).ok_or_else(|| unexpected(value))?),
            Expr::MethodCall(call) => self.method(call)?,
            other => return Err(unexpected(other)),
        };
        self.tape.find(operation).ok_or_else(|| format!("`{}` is no operation of the tape", value.to_token_stream()))
    }

    fn field(&self, field: &syn::ExprField) -> Result<u32, String> {
        let Member::Named(name) = &field.member else { return Err(unexpected(field)) };
        match &*field.base.to_token_stream().to_string() {
            "p" => {
                let is_this = |input: &u32| ident(&self.tape.names[input]) == *name;
                (0..place(self.tape.sizes()[0])).find(is_this).ok_or_else(|| unexpected(field))
            }
            "k" => {
                let constants = self.tape.function("constants").ok_or_else(|| unexpected(field))?;
                let is_this = |(part, _): &(&ResultField, u32)| ident(&part.name) == *name;
                let constant = constants.parts.iter().zip(constants.results()).find(is_this);
                constant.map(|(_, value)| value).ok_or_else(|| unexpected(field))
            }
            _ => Err(unexpected(field)),
        }
    }

    fn method(&self, call: &syn::ExprMethodCall) -> Result<Operation, String> {
        let x = self.value(&call.receiver)?;
        let arguments: Vec<&Expr> = call.args.iter().collect();
        use Operation as Op;
        Ok(match (&*call.method.to_string(), &arguments[..]) {
            ("recip", []) => Op::Recip(x),
            ("sqrt", []) => Op::Sqrt(x),
            ("sin", []) => Op::Sin(x),
            ("cos", []) => Op::Cos(x),
            ("sin_cos", []) => Op::SinCos(x),
            ("tan", []) => Op::Tan(x),
            ("asin", []) => Op::Asin(x),
            ("acos", []) => Op::Acos(x),
            ("atan", []) => Op::Atan(x),
            ("exp", []) => Op::Exp(x),
            ("ln", []) => Op::Ln(x),
            ("sinh", []) => Op::Sinh(x),
            ("cosh", []) => Op::Cosh(x),
            ("tanh", []) => Op::Tanh(x),
            ("abs", []) => Op::Abs(x),
            ("sign", []) => Op::Sign(x),
            ("floor", []) => Op::Floor(x),
            ("min", [y]) => Op::Min(x, self.value(y)?),
            ("max", [y]) => Op::Max(x, self.value(y)?),
            ("hypot", [y]) => Op::Hypot(x, self.value(y)?),
            ("atan2", [y]) => Op::Atan2(x, self.value(y)?),
            ("pow", [y]) => Op::Pow(x, self.value(y)?),
            ("powi", [exponent]) => Op::PowI(x, number(exponent)? as i32),
            ("powf", [exponent]) => Op::PowF(x, number(exponent)?),
            ("mul_add", [y, z]) => Op::MulAdd(x, self.value(y)?, self.value(z)?),
            ("neg_mul_add", [y, z]) => Op::NegMulAdd(x, self.value(y)?, self.value(z)?),
            _ => return Err(unexpected(call)),
        })
    }
}

/// The default value of a parameter: `replace("O2A").unwrap_or(VALUE)`.
fn default_value(value: &Expr) -> Option<&Expr> {
    let Expr::MethodCall(call) = value else { return None };
    (call.method == "unwrap_or").then(|| &call.args[0])
}

/// The number in `R::from_number(NUMBER)` or `R::zero()`.
fn literal(value: &Expr) -> Option<f64> {
    let Expr::Call(call) = value else { return None };
    match &*call.func.to_token_stream().to_string() {
        "R :: zero" => Some(0.0),
        "R :: from_number" => number(&call.args[0]).ok(),
        _ => None,
    }
}

/// A number as a literal.
fn number(value: &Expr) -> Result<f64, String> {
    let parsed = match value {
        Expr::Lit(ExprLit { lit: Lit::Float(number), .. }) => number.base10_parse(),
        Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => number.base10_parse(),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => return number(&unary.expr).map(|number| -number),
        Expr::Path(path) if path.to_token_stream().to_string() == "f64 :: INFINITY" => Ok(f64::INFINITY),
        other => return Err(unexpected(other)),
    };
    parsed.map_err(|_| unexpected(value))
}

fn index(value: &Expr) -> Result<usize, String> {
    number(value).map(|number| number as usize)
}

fn unexpected(syntax: &impl ToTokens) -> String {
    format!("unexpected `{}`", syntax.to_token_stream())
}
