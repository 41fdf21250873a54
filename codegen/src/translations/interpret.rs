//! Runs generated functions without compiling them: the syntax that is about to be written is evaluated as it stands.

mod module;

use std::collections::HashMap;
use std::fmt::Debug;

use qrm_core::{DoubleDouble, Scalar};
use quote::ToTokens;
use syn::{BinOp, Expr, ExprLit, FnArg, ItemFn, Lit, Member, Pat, Stmt, UnOp};

pub(super) use module::GeneratedModule;

/// A number that generated functions can be run on.
pub(super) trait Number: Scalar + PartialEq + Debug {
    /// The number that a literal means in the scene: a decimal, whatever a double makes of it.
    fn literal(digits: &str) -> Option<Self>;

    /// What stands for the next parameter, whose value in the scene this is.
    #[must_use]
    fn parameter(self) -> Self {
        self
    }
}

impl Number for f64 {
    fn literal(digits: &str) -> Option<Self> {
        digits.parse().ok()
    }
}

impl Number for DoubleDouble {
    fn literal(digits: &str) -> Option<Self> {
        let number = qrm_scene::expression::Number::parse(digits)?;
        Some(Self::sum(number.value, number.rest))
    }
}

/// A value in a running function.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value<N> {
    Number(N),
    Truth(bool),
    /// A closure that gives nothing, and what it gives.
    Nothing,
    List(Vec<Value<N>>),
    Fields(HashMap<String, Value<N>>),
}

impl<N: Number> Value<N> {
    pub(super) fn list(numbers: &[f64]) -> Self {
        Self::List(numbers.iter().map(|&n| Self::Number(N::from_f64(n))).collect())
    }

    pub(super) fn fields<const K: usize>(fields: [(&str, Self); K]) -> Self {
        Self::Fields(fields.map(|(name, value)| (name.to_owned(), value)).into())
    }

    /// The truths in a list.
    pub(super) fn truths(&self) -> Vec<bool> {
        match self {
            Self::Truth(truth) => vec![*truth],
            Self::List(items) => items.iter().flat_map(Self::truths).collect(),
            _ => Vec::new(),
        }
    }

    /// All numbers inside, fields left out.
    pub(super) fn numbers(&self) -> Vec<N> {
        match self {
            Self::Number(n) => vec![*n],
            Self::Truth(_) | Self::Nothing | Self::Fields(_) => Vec::new(),
            Self::List(items) => items.iter().flat_map(Self::numbers).collect(),
        }
    }

    pub(super) fn field(&self, name: &str) -> Result<&Self, String> {
        match self {
            Self::Fields(fields) => fields.get(name).ok_or_else(|| format!("no field `{name}`")),
            _ => Err(format!("`{name}` asked of something without fields")),
        }
    }

    fn number(&self) -> Result<N, String> {
        match self {
            Self::Number(n) => Ok(*n),
            other => Err(format!("{other:?} is not a number")),
        }
    }
}

/// Runs a function with these arguments, in their order.
pub(super) fn run<N: Number>(function: &ItemFn, arguments: &[Value<N>]) -> Result<Value<N>, String> {
    run_block(&function.sig, &function.block, arguments)
}

/// Runs the body of a function or method.
pub(super) fn run_block<N: Number>(
    signature: &syn::Signature,
    block: &syn::Block,
    arguments: &[Value<N>],
) -> Result<Value<N>, String> {
    let mut scope = Scope { names: HashMap::new() };
    if signature.inputs.len() != arguments.len() {
        return Err(format!("`{}` takes {} arguments", signature.ident, signature.inputs.len()));
    }
    for (input, value) in signature.inputs.iter().zip(arguments) {
        match input {
            FnArg::Receiver(_) => scope.names.insert("self".to_owned(), value.clone()).map_or((), |_| ()),
            FnArg::Typed(input) => scope.bind(&input.pat, value.clone())?,
        }
    }
    scope.block(block)
}

struct Scope<N> {
    names: HashMap<String, Value<N>>,
}

impl<N: Number> Scope<N> {
    fn block(&mut self, block: &syn::Block) -> Result<Value<N>, String> {
        for statement in &block.stmts {
            match statement {
                Stmt::Local(local) => {
                    let value = local.init.as_ref().ok_or("a `let` without a value")?;
                    let value = self.value(&value.expr)?;
                    self.bind(&local.pat, value)?;
                }
                Stmt::Expr(Expr::Assign(assignment), Some(_)) => {
                    let value = self.value(&assignment.right)?;
                    *self.entry(&assignment.left)? = value;
                }
                Stmt::Expr(value, None) => return self.value(value),
                other => return Err(format!("unexpected statement `{}`", other.to_token_stream())),
            }
        }
        Err("a function without a result".to_owned())
    }

    fn bind(&mut self, pattern: &Pat, value: Value<N>) -> Result<(), String> {
        match (pattern, value) {
            (Pat::Wild(_), _) => {}
            (Pat::Ident(name), value) => {
                self.names.insert(name.ident.to_string(), value);
            }
            (
                Pat::Slice(syn::PatSlice { elems, .. }) | Pat::Tuple(syn::PatTuple { elems, .. }),
                Value::List(values),
            ) => {
                if elems.len() != values.len() {
                    return Err(format!("{} names for {} values", elems.len(), values.len()));
                }
                for (pattern, value) in elems.iter().zip(values) {
                    self.bind(pattern, value)?;
                }
            }
            (Pat::Struct(pattern), Value::Fields(values)) => {
                for field in &pattern.fields {
                    let Member::Named(name) = &field.member else { return Err("unexpected tuple struct".to_owned()) };
                    let value = values.get(&name.to_string()).ok_or_else(|| format!("no field `{name}`"))?;
                    self.bind(&field.pat, value.clone())?;
                }
            }
            (pattern, _) => return Err(format!("unexpected pattern `{}`", pattern.to_token_stream())),
        }
        Ok(())
    }

    fn values<'e>(&self, values: impl IntoIterator<Item = &'e Expr>) -> Result<Vec<Value<N>>, String> {
        values.into_iter().map(|value| self.value(value)).collect()
    }

    fn value(&self, value: &Expr) -> Result<Value<N>, String> {
        match value {
            Expr::Paren(inner) => self.value(&inner.expr),
            Expr::Reference(inner) => self.value(&inner.expr),
            Expr::Lit(ExprLit { lit: Lit::Float(n), .. }) => literal(n.base10_digits()),
            Expr::Lit(ExprLit { lit: Lit::Int(n), .. }) => literal(n.base10_digits()),
            // The name of a parameter, for the closure.
            Expr::Lit(ExprLit { lit: Lit::Str(_), .. }) => Ok(Value::Nothing),
            Expr::Lit(ExprLit { lit: Lit::Bool(truth), .. }) => Ok(Value::Truth(truth.value)),
            Expr::Path(path) => match path.path.get_ident() {
                Some(name) => {
                    self.names.get(&name.to_string()).cloned().ok_or_else(|| format!("unknown name `{name}`"))
                }
                None => constant(&path.to_token_stream().to_string()),
            },
            Expr::Unary(unary) => match unary.op {
                UnOp::Neg(_) => Ok(Value::Number(-self.value(&unary.expr)?.number()?)),
                UnOp::Deref(_) => self.value(&unary.expr),
                _ => Err("unexpected operator".to_owned()),
            },
            Expr::Binary(binary) => {
                let (a, b) = (self.value(&binary.left)?.number()?, self.value(&binary.right)?.number()?);
                Ok(Value::Number(match binary.op {
                    BinOp::Add(_) => a + b,
                    BinOp::Sub(_) => a - b,
                    BinOp::Mul(_) => a * b,
                    BinOp::Div(_) => a / b,
                    _ => return Err("unexpected operator".to_owned()),
                }))
            }
            Expr::Field(_) => self.place(value).cloned(),
            Expr::Index(index) => {
                let place = self.value(&index.index)?.number()?;
                match self.value(&index.expr)? {
                    Value::List(items) => {
                        items.get(index_of(place)).cloned().ok_or_else(|| format!("no element {place:?}"))
                    }
                    _ => Err("an index into something that is no list".to_owned()),
                }
            }
            Expr::Repeat(repeat) => {
                let count = self.value(&repeat.len)?.number()?;
                Ok(Value::List(vec![self.value(&repeat.expr)?; index_of(count)]))
            }
            Expr::Block(inner) => {
                let mut scope = Self { names: self.names.clone() };
                scope.block(&inner.block)
            }
            Expr::Array(array) => self.values(&array.elems).map(Value::List),
            Expr::Tuple(tuple) => self.values(&tuple.elems).map(Value::List),
            Expr::Struct(literal) => {
                let field = |f: &syn::FieldValue| match &f.member {
                    Member::Named(name) => Ok((name.to_string(), self.value(&f.expr)?)),
                    Member::Unnamed(_) => Err("unexpected tuple struct".to_owned()),
                };
                literal.fields.iter().map(field).collect::<Result<_, String>>().map(Value::Fields)
            }
            Expr::MethodCall(call) => {
                let receiver = self.value(&call.receiver)?;
                let mut arguments = self.values(&call.args)?;
                if let (Value::Nothing, "unwrap_or", 1) = (&receiver, call.method.to_string().as_str(), arguments.len())
                {
                    return Ok(Value::Number(arguments.remove(0).number()?.parameter()));
                }
                function(&call.method.to_string(), &receiver, &arguments)
            }
            Expr::Call(call) => self.call(call),
            other => Err(format!("unexpected expression `{}`", other.to_token_stream())),
        }
    }

    /// A name, or a field of one, where it is: a mechanism with all its parameters is not copied for one of them.
    fn place(&self, value: &Expr) -> Result<&Value<N>, String> {
        match value {
            Expr::Paren(inner) => self.place(&inner.expr),
            Expr::Reference(inner) => self.place(&inner.expr),
            Expr::Field(field) => match &field.member {
                Member::Named(name) => self.place(&field.base)?.field(&name.to_string()),
                Member::Unnamed(_) => Err("unexpected tuple field".to_owned()),
            },
            Expr::Path(path) => {
                let name = path.path.get_ident().map(ToString::to_string).unwrap_or_default();
                self.names.get(&name).ok_or_else(|| format!("unknown name `{name}`"))
            }
            other => Err(format!("fields of `{}`", other.to_token_stream())),
        }
    }

    /// An entry of a list under a name, to be changed.
    fn entry(&mut self, value: &Expr) -> Result<&mut Value<N>, String> {
        match value {
            Expr::Index(index) => {
                let place = self.value(&index.index)?.number()?;
                match self.entry(&index.expr)? {
                    Value::List(items) => items.get_mut(index_of(place)).ok_or_else(|| format!("no element {place:?}")),
                    _ => Err("an index into something that is no list".to_owned()),
                }
            }
            Expr::Path(path) => {
                let name = path.path.get_ident().map(ToString::to_string).unwrap_or_default();
                self.names.get_mut(&name).ok_or_else(|| format!("unknown name `{name}`"))
            }
            other => Err(format!("an assignment to `{}`", other.to_token_stream())),
        }
    }

    fn call(&self, call: &syn::ExprCall) -> Result<Value<N>, String> {
        let path = match &*call.func {
            Expr::Path(path) => {
                path.path.segments.iter().map(|part| part.ident.to_string()).collect::<Vec<_>>().join("::")
            }
            other => return Err(format!("unexpected call of `{}`", other.to_token_stream())),
        };
        let mut arguments = self.values(&call.args)?.into_iter();
        match (path.as_str(), arguments.next()) {
            (name, Some(_)) if self.names.get(name) == Some(&Value::Nothing) => Ok(Value::Nothing),
            ("R::zero", None) => Ok(Value::Number(N::zero())),
            ("R::pi", None) => Ok(Value::Number(N::pi())),
            ("R::from_f64" | "Some", Some(value)) => Ok(value),
            (path, Some(first)) if path.starts_with("f64::") || path.starts_with("R::") => {
                let name = path.split("::").nth(1).unwrap_or_default();
                function(name, &first, &arguments.collect::<Vec<_>>())
            }
            _ => Err(format!("unexpected call of `{path}`")),
        }
    }
}

fn literal<N: Number>(digits: &str) -> Result<Value<N>, String> {
    N::literal(digits).map(Value::Number).ok_or_else(|| format!("`{digits}` is not a number"))
}

/// A whole number as a place in a list.
fn index_of<N: Number>(place: N) -> usize {
    place.to_f64() as usize
}

fn constant<N: Number>(path: &str) -> Result<Value<N>, String> {
    match path.replace(' ', "").as_str() {
        "f64::INFINITY" => Ok(Value::Number(N::from_f64(f64::INFINITY))),
        "core::f64::consts::PI" => Ok(Value::Number(N::pi())),
        "core::marker::PhantomData" => Ok(Value::List(Vec::new())),
        other => Err(format!("unknown name `{other}`")),
    }
}

fn function<N: Number>(name: &str, receiver: &Value<N>, arguments: &[Value<N>]) -> Result<Value<N>, String> {
    let x = receiver.number()?;
    let y = arguments.first().map(Value::number).transpose()?;
    let z = arguments.get(1).map(Value::number).transpose()?;
    match (name, y, z) {
        ("mul_add", Some(y), Some(z)) => return Ok(Value::Number(x.mul_add(y, z))),
        ("neg_mul_add", Some(y), Some(z)) => return Ok(Value::Number(x.neg_mul_add(y, z))),
        (_, _, Some(_)) => return Err(format!("unexpected function `{name}`")),
        _ => {}
    }
    Ok(Value::Number(match (name, y) {
        ("sin_cos", None) => {
            let (sine, cosine) = x.sin_cos();
            return Ok(Value::List(vec![Value::Number(sine), Value::Number(cosine)]));
        }
        ("sin", None) => x.sin(),
        ("cos", None) => x.cos(),
        ("tan", None) => x.tan(),
        ("asin", None) => x.asin(),
        ("acos", None) => x.acos(),
        ("atan", None) => x.atan(),
        ("sinh", None) => x.sinh(),
        ("cosh", None) => x.cosh(),
        ("tanh", None) => x.tanh(),
        ("sign", None) => x.sign(),
        ("floor", None) => x.floor(),
        ("exp", None) => x.exp(),
        ("ln", None) => x.ln(),
        ("sqrt", None) => x.sqrt(),
        ("abs", None) => x.abs(),
        ("recip", None) => x.recip(),
        ("powf", Some(y)) => x.powf(y.to_f64()),
        ("pow", Some(y)) => x.pow(y),
        ("powi", Some(y)) => x.powi(y.to_f64() as i32),
        ("hypot", Some(y)) => x.hypot(y),
        ("atan2", Some(y)) => x.atan2(y),
        ("min", Some(y)) => x.min(y),
        ("max", Some(y)) => x.max(y),
        _ => return Err(format!("unexpected function `{name}`")),
    }))
}
