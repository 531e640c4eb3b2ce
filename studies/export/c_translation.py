"""Translation of Python functions of numbers and arrays into C.

The averaged motor (`studies.export.reduced_motor`) runs in Python and in exported C from the same source, so that each
of its formulas stands once.  The translation covers annotated functions of a module (`float`, `int`, `Array`: pointer
to double), its constants in capitals, and in the function bodies assignments, if, while, return, arithmetic,
comparisons, conditional expressions, indexed arrays, and calls of each other and of `sqrt`, `exp`, `sin`, `cos`,
`atan2`, `log`, `abs`, `min`, `max` and `int`.  A variable without an annotation is a double.  Anything else is refused
with its line.
"""

import ast

TYPES = {"float": "double", "int": "int", "Array": "double *"}
PREFIX = "model_"  # of the names of functions in C
READ_ONLY = ("p", "tables")  # arguments that no translated function changes: const in C
CALLS = {
    "abs": "fabs", "min": "fmin", "max": "fmax", "int": "(int)", "sqrt": "sqrt", "exp": "exp", "sin": "sin",
    "cos": "cos", "atan2": "atan2", "log": "log",
}  # fmt: skip
OPERATORS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
    ast.Eq: "==", ast.NotEq: "!=", ast.And: "&&", ast.Or: "||", ast.USub: "-", ast.Not: "!",
}  # fmt: skip


class UntranslatableError(ValueError):
    """Python code outside the subset that is translated; the text names its line."""


def c_source(python: str) -> tuple[str, str]:
    r"""Return (constants, functions) in C99 of the source text of a module; functions are static.

    Examples
    --------
    >>> constants, functions = c_source("N = 3\ndef twice(x: float) -> float:\n    return 2.0 * x")
    >>> print(constants)
    #define N 3
    >>> print(functions.splitlines()[0])
    static double model_twice(double x);
    """
    body = ast.parse(python).body
    constants = [
        f"#define {ast.unparse(node.targets[0])} {ast.unparse(node.value)}"
        for node in body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
    ]
    nodes = [node for node in body if isinstance(node, ast.FunctionDef)]
    functions = [_Function(node, {each.name for each in nodes}) for node in nodes]
    heads = [f"{function.head};" for function in functions]
    return "\n".join(constants), "\n".join(heads) + "\n\n" + "\n\n".join(map(str, functions))


class _Function:
    """One function in C."""

    def __init__(self, node: ast.FunctionDef, names: set[str]):
        self.node, self.names = node, names
        self.locals = {each.arg: self._type(each.annotation) for each in node.args.args}
        arguments = ", ".join(
            f"{'const ' * (name in READ_ONLY)}{kind}{'' if kind.endswith('*') else ' '}{name}"
            for name, kind in self.locals.items()
        )
        self.head = f"static {self._type(node.returns)} {PREFIX}{node.name}({arguments})"

    def __str__(self) -> str:
        text = ast.get_docstring(self.node)
        comment, body = f"/* {text or self.node.name} */", self.node.body[text is not None :]
        lines = [line for statement in body for line in self._statement(statement)]
        return "\n".join([comment, self.head + " {", *(f"    {line}" for line in lines), "}"])

    def _type(self, annotation) -> str:
        if not isinstance(annotation, ast.Name) or annotation.id not in TYPES:
            raise UntranslatableError(f"line {self.node.lineno}: an annotation is none of {', '.join(TYPES)}")
        return TYPES[annotation.id]

    def _block(self, statements) -> list[str]:
        # a variable that is first assigned within a block is local to it
        outer, self.locals = self.locals, dict(self.locals)
        lines = [f"    {line}" for each in statements for line in self._statement(each)]
        self.locals = outer
        return lines

    def _statement(self, node) -> list[str]:
        match node:
            case ast.AnnAssign(target=ast.Name(id=name), value=value) if value is not None:
                self.locals[name] = self._type(node.annotation)
                return [f"{self.locals[name]} {name} = {self._of(value)};"]
            case ast.Assign(targets=[target]):
                fresh = isinstance(target, ast.Name) and target.id not in self.locals
                if fresh:
                    self.locals[ast.unparse(target)] = "double"
                return [f"{'double ' * fresh}{self._of(target)} = {self._of(node.value)};"]
            case ast.AugAssign():
                return [f"{self._of(node.target)} {OPERATORS[type(node.op)]}= {self._of(node.value)};"]
            case ast.Return():
                return [f"return {self._of(node.value)};"]
            case ast.Expr(value=ast.Call()):
                return [f"{self._of(node.value)};"]
            case ast.While():
                return [f"while ({self._of(node.test)}) {{", *self._block(node.body), "}"]
            case ast.If():
                lines = [f"if ({self._of(node.test)}) {{", *self._block(node.body), "}"]
                return [*lines, "else {", *self._block(node.orelse), "}"] if node.orelse else lines
        raise UntranslatableError(f"line {node.lineno}: {ast.unparse(node)}")

    def _of(self, node) -> str:
        match node:
            case ast.Constant(value=bool(value)):
                return str(int(value))
            case ast.Constant(value=int() | float()):
                return repr(node.value)
            case ast.Name():
                return node.id
            case ast.Attribute(value=ast.Name(), attr=constant) if constant.isupper():
                return constant  # of another module of the same program
            case ast.Subscript():
                return f"{self._of(node.value)}[{self._of(node.slice)}]"
            case ast.UnaryOp():
                return f"({OPERATORS[type(node.op)]}{self._of(node.operand)})"
            case ast.BinOp(op=ast.Pow()):
                return f"pow({self._of(node.left)}, {self._of(node.right)})"
            case ast.BinOp() if type(node.op) in OPERATORS:
                return f"({self._of(node.left)} {OPERATORS[type(node.op)]} {self._of(node.right)})"
            case ast.BoolOp():
                return "(" + f" {OPERATORS[type(node.op)]} ".join(map(self._of, node.values)) + ")"
            case ast.Compare(ops=[operator], comparators=[right]):
                return f"({self._of(node.left)} {OPERATORS[type(operator)]} {self._of(right)})"
            case ast.IfExp():
                return f"({self._of(node.test)} ? {self._of(node.body)} : {self._of(node.orelse)})"
            case ast.Call(func=ast.Name(id=name)) if name in CALLS or name in self.names:
                called = PREFIX + name if name in self.names else CALLS[name]
                return f"{called}({', '.join(map(self._of, node.args))})"
        raise UntranslatableError(f"line {node.lineno}: {ast.unparse(node)}")
