//! Runs generated functions without compiling them: the syntax that is about to be written is evaluated as it stands.

use std::collections::HashMap;

use qrm_core::Scalar;
use quote::ToTokens;
use syn::{BinOp, Expr, ExprLit, FnArg, ItemFn, Lit, Member, Pat, Stmt, UnOp};

/// A value in a running function.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Truth(bool),
    /// A closure that gives nothing, and what it gives.
    Nothing,
    List(Vec<Value>),
    Fields(HashMap<String, Value>),
}

impl Value {
    pub(super) fn list(numbers: &[f64]) -> Self {
        Self::List(numbers.iter().map(|&n| Self::Number(n)).collect())
    }

    /// All numbers inside, fields left out.
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(n) => vec![*n],
            Self::Truth(_) | Self::Nothing | Self::Fields(_) => Vec::new(),
            Self::List(items) => items.iter().flat_map(Self::numbers).collect(),
        }
    }

    pub(super) fn field(&self, name: &str) -> Result<&Value, String> {
        match self {
            Self::Fields(fields) => fields.get(name).ok_or_else(|| format!("no field `{name}`")),
            _ => Err(format!("`{name}` asked of something without fields")),
        }
    }

    pub(super) fn items(&self) -> Result<Vec<Value>, String> {
        match self {
            Self::List(items) => Ok(items.clone()),
            other => Err(format!("{other:?} is not a list")),
        }
    }

    fn number(&self) -> Result<f64, String> {
        match self {
            Self::Number(n) => Ok(*n),
            other => Err(format!("{other:?} is not a number")),
        }
    }
}

/// Runs a function with these arguments, in their order.
pub(super) fn run(function: &ItemFn, arguments: &[Value]) -> Result<Value, String> {
    run_block(&function.sig, &function.block, arguments)
}

/// Runs the body of a function or method.
pub(super) fn run_block(signature: &syn::Signature, block: &syn::Block, arguments: &[Value]) -> Result<Value, String> {
    let mut scope = Scope::default();
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

#[derive(Default)]
struct Scope {
    names: HashMap<String, Value>,
}

impl Scope {
    fn block(&mut self, block: &syn::Block) -> Result<Value, String> {
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

    fn bind(&mut self, pattern: &Pat, value: Value) -> Result<(), String> {
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

    fn values<'e>(&self, values: impl IntoIterator<Item = &'e Expr>) -> Result<Vec<Value>, String> {
        values.into_iter().map(|value| self.value(value)).collect()
    }

    fn value(&self, value: &Expr) -> Result<Value, String> {
        match value {
            Expr::Paren(inner) => self.value(&inner.expr),
            Expr::Reference(inner) => self.value(&inner.expr),
            Expr::Lit(ExprLit { lit: Lit::Float(n), .. }) => {
                n.base10_parse().map(Value::Number).map_err(|e| e.to_string())
            }
            Expr::Lit(ExprLit { lit: Lit::Int(n), .. }) => {
                n.base10_parse().map(Value::Number).map_err(|e| e.to_string())
            }
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
                        items.get(place as usize).cloned().ok_or_else(|| format!("no element {place}"))
                    }
                    _ => Err("an index into something that is no list".to_owned()),
                }
            }
            Expr::Repeat(repeat) => {
                let count = self.value(&repeat.len)?.number()?;
                Ok(Value::List(vec![self.value(&repeat.expr)?; count as usize]))
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
                    return Ok(arguments.remove(0));
                }
                function(&call.method.to_string(), &receiver, &arguments)
            }
            Expr::Call(call) => self.call(call),
            other => Err(format!("unexpected expression `{}`", other.to_token_stream())),
        }
    }

    /// A name, or a field of one, where it is: a mechanism with all its parameters is not copied for one of them.
    fn place(&self, value: &Expr) -> Result<&Value, String> {
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
    fn entry(&mut self, value: &Expr) -> Result<&mut Value, String> {
        match value {
            Expr::Index(index) => {
                let place = self.value(&index.index)?.number()?;
                match self.entry(&index.expr)? {
                    Value::List(items) => items.get_mut(place as usize).ok_or_else(|| format!("no element {place}")),
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

    fn call(&self, call: &syn::ExprCall) -> Result<Value, String> {
        let path = match &*call.func {
            Expr::Path(path) => {
                path.path.segments.iter().map(|part| part.ident.to_string()).collect::<Vec<_>>().join("::")
            }
            other => return Err(format!("unexpected call of `{}`", other.to_token_stream())),
        };
        let mut arguments = self.values(&call.args)?.into_iter();
        match (path.as_str(), arguments.next()) {
            (name, Some(_)) if self.names.get(name) == Some(&Value::Nothing) => Ok(Value::Nothing),
            ("R::zero", None) => Ok(Value::Number(0.0)),
            ("R::pi", None) => Ok(Value::Number(std::f64::consts::PI)),
            ("R::from_f64" | "Some", Some(value)) => Ok(value),
            (path, Some(first)) if path.starts_with("f64::") || path.starts_with("R::") => {
                let name = path.split("::").nth(1).unwrap_or_default();
                function(name, &first, &arguments.collect::<Vec<_>>())
            }
            _ => Err(format!("unexpected call of `{path}`")),
        }
    }
}

fn constant(path: &str) -> Result<Value, String> {
    match path.replace(' ', "").as_str() {
        "f64::INFINITY" => Ok(Value::Number(f64::INFINITY)),
        "core::f64::consts::PI" => Ok(Value::Number(std::f64::consts::PI)),
        "core::marker::PhantomData" => Ok(Value::List(Vec::new())),
        other => Err(format!("unknown name `{other}`")),
    }
}

fn function(name: &str, receiver: &Value, arguments: &[Value]) -> Result<Value, String> {
    let x = receiver.number()?;
    let y = arguments.first().map(Value::number).transpose()?;
    let z = arguments.get(1).map(Value::number).transpose()?;
    match (name, y, z) {
        ("mul_add", Some(y), Some(z)) => return Ok(Value::Number(x * y + z)),
        ("neg_mul_add", Some(y), Some(z)) => return Ok(Value::Number(z - x * y)),
        (_, _, Some(_)) => return Err(format!("unexpected function `{name}`")),
        _ => {}
    }
    Ok(Value::Number(match (name, y) {
        ("sin_cos", None) => {
            let (sine, cosine) = Scalar::sin_cos(x);
            return Ok(Value::list(&[sine, cosine]));
        }
        ("sin", None) => Scalar::sin(x),
        ("cos", None) => Scalar::cos(x),
        ("tan", None) => x.tan(),
        ("asin", None) => x.asin(),
        ("acos", None) => x.acos(),
        ("atan", None) => x.atan(),
        ("sinh", None) => x.sinh(),
        ("cosh", None) => x.cosh(),
        ("tanh", None) => x.tanh(),
        ("sign", None) => x.sign(),
        ("exp", None) => x.exp(),
        ("ln", None) => x.ln(),
        ("sqrt", None) => x.sqrt(),
        ("abs", None) => x.abs(),
        ("recip", None) => x.recip(),
        ("powf" | "pow", Some(y)) => x.powf(y),
        ("powi", Some(y)) => x.powi(y as i32),
        ("hypot", Some(y)) => x.hypot(y),
        ("atan2", Some(y)) => x.atan2(y),
        ("min", Some(y)) => Scalar::min(x, y),
        ("max", Some(y)) => Scalar::max(x, y),
        _ => return Err(format!("unexpected function `{name}`")),
    }))
}
