"""Whole numbers of a user's law as floats: numba computes those of Python as integers of 64 bits.

Such an integer to a negative power is 0 (`10 ** -1` with the exponent in a name; numba 0.68.1), and a product beyond
2^63 wraps around. In Python both are right.
"""

import ast


def with_floats(source: str) -> str:
    """Return the text of a law whose powers and products of whole numbers are computed with floats.

    Indices and the arguments of `range` stay whole.

    Examples
    --------
    >>> print(with_floats("def f(x): return 10 ** POWER * x[2 * 3] + k ** -2"))
    def f(x):
        return 10.0 ** (1.0 * POWER) * x[2 * 3] + (1.0 * k) ** (-2)
    """
    return ast.unparse(ast.fix_missing_locations(_Floats().visit(ast.parse(source))))


class _Floats(ast.NodeTransformer):
    def visit_Subscript(self, node):
        node.value = self.visit(node.value)
        return node

    def visit_Call(self, node):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == "range":
            return node
        if name == "pow" and len(node.args) == 2 and not node.keywords:
            return self.visit(ast.BinOp(node.args[0], ast.Pow(), node.args[1]))
        return self.generic_visit(node)

    def visit_AugAssign(self, node):
        if isinstance(node.op, ast.Pow) and isinstance(node.target, ast.Name):
            power = ast.BinOp(ast.Name(node.target.id, ast.Load()), ast.Pow(), node.value)
            return ast.Assign([node.target], self.visit(power))
        return self.generic_visit(node)

    def visit_BinOp(self, node):
        node = self.generic_visit(node)
        if isinstance(node.op, ast.Pow):
            node.left = _float(node.left)
            # a power of a constant whole number stays a product
            node.right = node.right if _whole(node.right) is not None else _float(node.right)
        elif isinstance(node.op, ast.Mult | ast.Div):
            node.left, node.right = (
                each if _whole(each) is None else ast.Constant(float(_whole(each))) for each in (node.left, node.right)
            )
            if isinstance(node.left, ast.Name) and isinstance(node.right, ast.Name):
                node.left = _float(node.left)
        return node


def _whole(node) -> int | None:
    """Return the whole number that a constant is, with its sign; None of anything else."""
    sign = 1
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        sign, node = -1, node.operand
    is_whole = isinstance(node, ast.Constant) and type(node.value) is int and node.value < 10**300
    return sign * node.value if is_whole else None


def _float(node):
    """Return an expression as a float."""
    if isinstance(node, ast.Constant) and type(node.value) is float:
        return node
    whole = _whole(node)
    return ast.BinOp(ast.Constant(1.0), ast.Mult(), node) if whole is None else ast.Constant(float(whole))
