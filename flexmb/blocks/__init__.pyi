"""Names that this room offers beside those of flexmb itself."""

from .guides import double_parallel_guide as double_parallel_guide
from .guides import parallel_guide as parallel_guide
from .guides import straight_line_stage as straight_line_stage
from .guides import xy_stage as xy_stage
from .hinges import notch_four_bar as notch_four_bar
from .hinges import notch_hinge as notch_hinge
from .pivots import butterfly_pivot as butterfly_pivot
from .pivots import cartwheel as cartwheel
from .pivots import cross_pivot as cross_pivot
from .springs import folded_leaf_spring as folded_leaf_spring
from .springs import wire_flexure as wire_flexure
