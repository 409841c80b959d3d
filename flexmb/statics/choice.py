"""Whether a model is solved by sparse factors."""

from ..arguments import check_flag
from ..math.sparse import LARGE
from ..model.model import Model


def by_sparse(model: Model, sparse: bool | None) -> bool:
    """Whether a model is solved by sparse factors: as is asked, or, where nothing is, as it is large.

    Args:
        sparse: What a public function was given.

    Raises:
        TypeError: It is neither a truth value nor None.
    """
    if sparse is None:
        return model.topology.n_x >= LARGE
    check_flag("sparse", sparse)
    return bool(sparse)
