//! Expressions of numbers.

use proc_macro2::Ident;
use syn::{BinOp, Expr, ExprLit, Lit, UnOp};

use super::{Untranslated, member, shape};
use crate::ir::{Builtin, Expression, Operator};

/// The intermediate representation of an expression.
pub(super) fn expression(value: &Expr) -> Result<Expression, Untranslated> {
    match value {
        Expr::Paren(inner) => expression(&inner.expr),
        Expr::Reference(inner) => expression(&inner.expr),
        Expr::Lit(ExprLit { lit: Lit::Float(number), .. }) => Ok(Expression::Number(number.base10_digits().to_owned())),
        // A whole exponent.
        Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => {
            Ok(Expression::Number(format!("{}.0", number.base10_digits())))
        }
        Expr::Lit(ExprLit { lit: Lit::Bool(boolean), .. }) => Ok(Expression::Boolean(boolean.value)),
        Expr::Path(path) => match path.path.get_ident() {
            Some(name) if name == "None" => Ok(Expression::Infinity.negative()),
            Some(name) => Ok(Expression::Name(identifier(name))),
            None if path_of(&path.path) == "f64::INFINITY" => Ok(Expression::Infinity),
            None => Err(Untranslated::new("the name", value)),
        },
        Expr::Unary(unary) => match unary.op {
            UnOp::Neg(_) => Ok(expression(&unary.expr)?.negative()),
            UnOp::Deref(_) => expression(&unary.expr),
            _ => Err(Untranslated::new("the operator of", value)),
        },
        Expr::Binary(binary) => {
            let operator = match binary.op {
                BinOp::Add(_) => Operator::Add,
                BinOp::Sub(_) => Operator::Subtract,
                BinOp::Mul(_) => Operator::Multiply,
                BinOp::Div(_) => Operator::Divide,
                _ => return Err(Untranslated::new("the operator of", value)),
            };
            Ok(Expression::binary(operator, expression(&binary.left)?, expression(&binary.right)?))
        }
        Expr::Field(field) => Ok(expression(&field.base)?.field(&member(&field.member)?)),
        Expr::Index(index) => Ok(expression(&index.expr)?.element(shape::whole(&index.index)?)),
        Expr::MethodCall(call) => {
            let arguments = expressions(std::iter::once(&*call.receiver).chain(&call.args))?;
            self::call(&call.method.to_string(), arguments).ok_or_else(|| Untranslated::new("the call", value))
        }
        Expr::Call(call) => {
            let Expr::Path(path) = &*call.func else { return Err(Untranslated::new("the call", value)) };
            let mut arguments = expressions(&call.args)?;
            match (path_of(&path.path).as_str(), arguments.len()) {
                ("R::zero", 0) => Ok(Expression::Number("0.0".to_owned())),
                ("R::pi", 0) => Ok(Expression::Pi),
                ("R::from_f64" | "Some", 1) => Ok(arguments.remove(0)),
                (path, _) => {
                    let function = path.strip_prefix("R::").and_then(|name| self::call(name, arguments));
                    function.ok_or_else(|| Untranslated::new("the call", value))
                }
            }
        }
        _ => Err(Untranslated::new("the expression", value)),
    }
}

fn expressions<'e>(values: impl IntoIterator<Item = &'e Expr>) -> Result<Vec<Expression>, Untranslated> {
    values.into_iter().map(expression).collect()
}

/// A name without the mark of a raw identifier; the mechanism is called `m` in methods too.
pub(super) fn identifier(name: &Ident) -> String {
    let name = name.to_string();
    match name.as_str() {
        "self" => "m".to_owned(),
        _ => name.strip_prefix("r#").unwrap_or(&name).to_owned(),
    }
}

fn path_of(path: &syn::Path) -> String {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect::<Vec<_>>().join("::")
}

/// A call of a function; `None` if there is none of this name and number of arguments.
fn call(name: &str, arguments: Vec<Expression>) -> Option<Expression> {
    use Operator::{Add, Divide, Multiply, Subtract};
    match (name, &arguments[..]) {
        // Whether product and sum are rounded together is left to the compiler, as it is in Rust.
        ("mul_add", [x, y, z]) => {
            let product = Expression::binary(Multiply, x.clone(), y.clone());
            Some(Expression::binary(Add, product, z.clone()))
        }
        ("neg_mul_add", [x, y, z]) => {
            let product = Expression::binary(Multiply, x.clone(), y.clone());
            Some(Expression::binary(Subtract, z.clone(), product))
        }
        ("recip", [x]) => Some(Expression::binary(Divide, Expression::Number("1.0".to_owned()), x.clone())),
        _ => {
            let builtin = builtin(name, arguments.len())?;
            Some(Expression::Call(builtin, arguments))
        }
    }
}

/// The builtin function with this name and so many arguments.
fn builtin(name: &str, arguments: usize) -> Option<Builtin> {
    Some(match (name, arguments) {
        ("sin", 1) => Builtin::Sin,
        ("cos", 1) => Builtin::Cos,
        ("tan", 1) => Builtin::Tan,
        ("asin", 1) => Builtin::Asin,
        ("acos", 1) => Builtin::Acos,
        ("atan", 1) => Builtin::Atan,
        ("sinh", 1) => Builtin::Sinh,
        ("cosh", 1) => Builtin::Cosh,
        ("tanh", 1) => Builtin::Tanh,
        ("exp", 1) => Builtin::Exp,
        ("ln", 1) => Builtin::Ln,
        ("sqrt", 1) => Builtin::Sqrt,
        ("abs", 1) => Builtin::Abs,
        ("floor", 1) => Builtin::Floor,
        ("sign", 1) => Builtin::Sign,
        ("powf" | "pow" | "powi", 2) => Builtin::Power,
        ("hypot", 2) => Builtin::Hypot,
        ("atan2", 2) => Builtin::Atan2,
        ("min", 2) => Builtin::Min,
        ("max", 2) => Builtin::Max,
        _ => return None,
    })
}
