//! Functions: arguments, statements, results.

use std::collections::BTreeSet;

use quote::ToTokens;
use syn::{Attribute, Block, Expr, FnArg, ImplItemFn, Pat, ReturnType, Signature, Stmt};

use super::documentation::documentation;
use super::expression::{expression, identifier};
use super::{Parser, Untranslated, member, shape};
use crate::ir::{Builtin, Expression, Function, Shape, Statement, StructKind, Variable};

impl Parser<'_> {
    pub(super) fn function(
        &self,
        signature: &Signature,
        block: &Block,
        attributes: &[Attribute],
    ) -> Result<Function, Untranslated> {
        let name = signature.ident.to_string();
        let ReturnType::Type(_, of) = &signature.output else {
            return Err(Untranslated::new("the signature", signature));
        };
        let (arguments, mut results) = (self.arguments(signature)?, self.sizes.results(&name, of)?);
        let body = Body::parse(&arguments, &mut results, block)?;
        Ok(Function { name, doc: documentation(attributes), arguments, results, body })
    }

    /// The constructor of parameters or constants.
    pub(super) fn constructor(&self, kind: StructKind, constructor: &ImplItemFn) -> Result<Function, Untranslated> {
        let arguments = match (kind, constructor.sig.inputs.first()) {
            // What replaces values are parameters too.
            (StructKind::Parameters, Some(FnArg::Typed(input))) => {
                vec![Variable { name: argument_name(&input.pat)?, shape: Shape::Struct(kind) }]
            }
            _ => self.arguments(&constructor.sig)?,
        };
        let mut results = vec![Variable { name: kind.name().to_owned(), shape: Shape::Struct(kind) }];
        let body = Body::parse(&arguments, &mut results, &constructor.block)?;
        Ok(Function { name: kind.name().to_owned(), doc: Vec::new(), arguments, results, body })
    }

    /// The arguments of a function.
    pub(super) fn arguments(&self, signature: &Signature) -> Result<Vec<Variable>, Untranslated> {
        let argument = |input: &FnArg| match input {
            FnArg::Receiver(_) => Ok(Variable { name: "m".to_owned(), shape: Shape::Struct(StructKind::Mechanism) }),
            FnArg::Typed(input) => {
                let name = argument_name(&input.pat)?;
                let is_mechanism = shape::last_segment(&input.ty).is_ok_and(|segment| segment.ident == self.mechanism);
                let shape = if is_mechanism { Shape::Struct(StructKind::Mechanism) } else { shape::shape(&input.ty)? };
                Ok(Variable { name, shape })
            }
        };
        signature.inputs.iter().map(argument).collect()
    }
}

/// The name of an argument. One with an underscore in front is not used.
fn argument_name(pattern: &Pat) -> Result<String, Untranslated> {
    let Pat::Ident(name) = pattern else { return Err(Untranslated::new("the argument", pattern)) };
    let name = identifier(&name.ident);
    Ok(name.strip_prefix('_').unwrap_or(&name).to_owned())
}

/// The statements of a function.
struct Body {
    statements: Vec<Statement>,
    /// What has a name.
    names: BTreeSet<String>,
}

impl Body {
    /// The statements; results that are called like something else get other names.
    fn parse(arguments: &[Variable], results: &mut [Variable], block: &Block) -> Result<Vec<Statement>, Untranslated> {
        let names = arguments.iter().map(|argument| argument.name.clone()).collect();
        let mut body = Self { statements: Vec::new(), names };
        let Some((Stmt::Expr(value, None), statements)) = block.stmts.split_last() else {
            return Err(Untranslated::new("the body", block));
        };
        for statement in statements {
            let Stmt::Local(local) = statement else { return Err(Untranslated::new("the statement", statement)) };
            let init = local.init.as_ref().ok_or_else(|| Untranslated::new("the statement", statement))?;
            body.statements.extend(documentation(&local.attrs).into_iter().map(Statement::Comment));
            body.bind(&local.pat, &init.expr)?;
        }
        let fields: Vec<String> = results.iter().map(|result| result.name.clone()).collect();
        for result in &mut *results {
            while body.names.contains(&result.name) {
                result.name.push('_');
            }
        }
        body.results(results, &fields, value)?;
        body.names.extend(results.iter().map(|result| result.name.clone()));
        match body.unknown() {
            Some(name) => Err(Untranslated(format!("the name `{name}`"))),
            None => Ok(body.statements),
        }
    }

    /// A name that stands for nothing in the function.
    fn unknown(&self) -> Option<String> {
        let mut unknown = None;
        for statement in &self.statements {
            statement.visit(&mut |value| match value {
                Expression::Name(name) if !self.names.contains(name) => unknown = Some(name.clone()),
                _ => {}
            });
        }
        unknown
    }

    /// Names what a pattern names.
    fn bind(&mut self, pattern: &Pat, value: &Expr) -> Result<(), Untranslated> {
        match (pattern, value) {
            (Pat::Tuple(pair), Expr::MethodCall(call)) if call.method == "sin_cos" => {
                let angle = expression(&call.receiver)?;
                for (pattern, builtin) in pair.elems.iter().zip([Builtin::Sin, Builtin::Cos]) {
                    self.define(pattern, Expression::Call(builtin, vec![angle.clone()]))?;
                }
                Ok(())
            }
            // A value of the scene, unless there is another one.
            (Pat::Ident(name), Expr::MethodCall(call)) if call.method == "unwrap_or" => {
                let (Expr::Call(replace), Some(own)) = (&*call.receiver, call.args.first()) else {
                    return Err(Untranslated::new("the call", value));
                };
                let other = expression(&replace.func)?.field(&identifier(&name.ident));
                self.define(pattern, Expression::Call(Builtin::ValueOr, vec![other, expression(own)?]))
            }
            (_, value) => {
                let value = expression(value)?;
                self.define(pattern, value)
            }
        }
    }

    fn define(&mut self, pattern: &Pat, value: Expression) -> Result<(), Untranslated> {
        match pattern {
            Pat::Wild(_) => {}
            Pat::Ident(name) => {
                let name = identifier(&name.ident);
                if !self.names.insert(name.clone()) {
                    return Err(Untranslated::new("a name that is given twice,", pattern));
                }
                let kind = match &value {
                    Expression::Field(of, field) if **of == Expression::name("m") => match field.as_str() {
                        "parameters" => Some(StructKind::Parameters),
                        "constants" => Some(StructKind::Constants),
                        _ => None,
                    },
                    _ => None,
                };
                self.statements.push(match kind {
                    Some(kind) => Statement::Alias { name, kind, of: value },
                    None => Statement::Let { name, value },
                });
            }
            Pat::Slice(list) => {
                for (i, pattern) in list.elems.iter().enumerate() {
                    self.define(pattern, value.clone().element(i))?;
                }
            }
            Pat::Struct(structure) => {
                for field in &structure.fields {
                    self.define(&field.pat, value.clone().field(&member(&field.member)?))?;
                }
            }
            _ => return Err(Untranslated::new("the pattern", pattern)),
        }
        Ok(())
    }

    /// Gives the results their values; `fields` are their names where they are fields of a struct.
    fn results(&mut self, results: &[Variable], fields: &[String], value: &Expr) -> Result<(), Untranslated> {
        match (results, value) {
            (_, Expr::Struct(structure)) if structure.rest.is_none() => {
                for field in &structure.fields {
                    let name = member(&field.member)?;
                    match results {
                        [Variable { name: result, shape: Shape::Struct(_) }] => {
                            if !is_marker(&field.expr) {
                                self.set(Expression::name(result).field(&name), Shape::Scalar, &field.expr)?;
                            }
                        }
                        _ => {
                            let place = fields.iter().position(|field| *field == name);
                            let place = place.ok_or_else(|| Untranslated::new("the field", &field.member))?;
                            self.set(Expression::name(&results[place].name), results[place].shape, &field.expr)?;
                        }
                    }
                }
                Ok(())
            }
            ([result], value) if result.shape == Shape::Scalar => {
                self.statements.push(Statement::Return(expression(value)?));
                Ok(())
            }
            ([result], value) => self.set(Expression::name(&result.name), result.shape, value),
            (results, Expr::Tuple(tuple)) if results.len() == tuple.elems.len() => {
                for (result, value) in results.iter().zip(&tuple.elems) {
                    self.set(Expression::name(&result.name), result.shape, value)?;
                }
                Ok(())
            }
            _ => Err(Untranslated::new("the result", value)),
        }
    }

    /// Fills a place.
    fn set(&mut self, place: Expression, shape: Shape, value: &Expr) -> Result<(), Untranslated> {
        let (count, inner) = match shape {
            Shape::Scalar => {
                self.statements.push(Statement::Assign { place, value: expression(value)? });
                return Ok(());
            }
            Shape::Vector(count) | Shape::Booleans(count) => (count, Shape::Scalar),
            Shape::Matrix(rows, columns) => (rows, Shape::Vector(columns)),
            Shape::Struct(_) => return Err(Untranslated::new("the result", value)),
        };
        match value {
            Expr::Array(array) if array.elems.len() == count => {
                for (i, element) in array.elems.iter().enumerate() {
                    self.set(place.clone().element(i), inner, element)?;
                }
                Ok(())
            }
            Expr::Block(block) => self.fill(&place, shape, &block.block),
            _ => Err(Untranslated::new("the result", value)),
        }
    }

    /// Fills a place with zeros first, then with the entries that are not zero.
    fn fill(&mut self, place: &Expression, shape: Shape, block: &Block) -> Result<(), Untranslated> {
        let wrong = || Untranslated::new("the block", block);
        let [Stmt::Local(zeros), entries @ .., Stmt::Expr(Expr::Path(result), None)] = &block.stmts[..] else {
            return Err(wrong());
        };
        let (Pat::Ident(rows), Some(init)) = (&zeros.pat, &zeros.init) else { return Err(wrong()) };
        if !is_zero(&init.expr) || !result.path.is_ident(&rows.ident) {
            return Err(wrong());
        }
        self.statements.push(Statement::Clear { place: place.clone(), shape });
        for entry in entries {
            let Stmt::Expr(Expr::Assign(entry), Some(_)) = entry else { return Err(wrong()) };
            let target = within(&expression(&entry.left)?, &identifier(&rows.ident), place).ok_or_else(wrong)?;
            self.set(target, Shape::Scalar, &entry.right)?;
        }
        Ok(())
    }
}

/// A place in a list as a place in a result.
fn within(place: &Expression, list: &str, result: &Expression) -> Option<Expression> {
    match place {
        Expression::Name(name) if name == list => Some(result.clone()),
        Expression::Element(outer, i) => Some(within(outer, list, result)?.element(*i)),
        _ => None,
    }
}

/// Whether a value is zeros throughout.
fn is_zero(value: &Expr) -> bool {
    match value {
        Expr::Repeat(repeat) => is_zero(&repeat.expr),
        other => expression(other) == Ok(Expression::Number("0.0".to_owned())),
    }
}

/// Whether a value stands for the type of numbers alone.
fn is_marker(value: &Expr) -> bool {
    value.to_token_stream().to_string().ends_with("PhantomData")
}
