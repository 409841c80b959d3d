"""Names that this room offers beside those of flexmb itself."""

from .light import LightResults as LightResults
from .light import Struct as Struct
from .light import StructArray as StructArray
from .light import spacar_light as spacar_light
from .light import spacar_light_model as spacar_light_model
