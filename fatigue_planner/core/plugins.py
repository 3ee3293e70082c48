"""Extension points, and the plug-ins that add to them.

An extension point is a `Registry`: kinds of settings by the name that an experiment file gives as `kind`. A plug-in is
a Python module that adds kinds with `register` when it is loaded. It is found through the entry points (group
`fatigue_planner.plugins`) of installed packages, or is a file that the user names (`--plugin`, `load_plugin`). An
experiment file can name a kind, never a plug-in: to open somebody's file runs nobody's code. Sections of the report
have a registry of their own (`output.reports.results.report`), as no experiment file names them.
"""

import hashlib
import importlib.util
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Generic, TypeVar, Union, get_args

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from fatigue_planner.core.errors import PluginError
from fatigue_planner.core.files import PACKAGE, digest_of_files
from fatigue_planner.core.settings import Settings

ENTRY_POINTS = "fatigue_planner.plugins"
# The module of a plug-in file is `fatplan_plugin_<stem of the file>`.
MODULE_PREFIX = "fatplan_plugin_"
# How the entry of a plug-in among the sources of a key begins.
OF_PLUGINS = "plug-in "

K = TypeVar("K", bound=Settings)
T = TypeVar("T", bound=type)


class Registry(Generic[K]):
    """The kinds of an extension point, by name.

    `Annotated[Base, registry]` is a field that holds one of them: a tagged union that plug-ins can add to.
    """

    def __init__(self, what: str, base: type[K]) -> None:
        self.what, self.base = what, base
        self._kinds: dict[str, type[K]] = {}
        self._adapter: TypeAdapter[K] | None = None
        _REGISTRIES.append(self)

    def add(self, kind: type[K]) -> None:
        """Add a kind. Raises PluginError if it has no name or another kind has the same name."""
        field = kind.model_fields.get("kind")
        names = get_args(field.annotation) if field else ()
        if len(names) != 1 or not isinstance(names[0], str):
            raise PluginError(f'{origin_of(kind)}: {kind.__name__} needs a name: `kind: Literal["..."]`.')
        known = self._kinds.get(names[0])
        if known is not None and origin_of(known) != origin_of(kind):
            raise PluginError(
                f"{origin_of(kind)}: the {self.what} {names[0]!r} is already defined in {origin_of(known)}."
            )
        self._kinds[names[0]] = kind
        self._adapter = None

    def kinds(self) -> Mapping[str, type[K]]:
        """The kinds by name, including those of installed plug-ins. Raises PluginError."""
        load_installed_plugins()
        return self._kinds

    def __get_pydantic_core_schema__(self, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        """Any of the kinds that are known when a value is validated."""
        strict, lax = (
            core_schema.with_info_plain_validator_function(partial(self._validate, s)) for s in (True, False)
        )
        return core_schema.lax_or_strict_schema(lax_schema=lax, strict_schema=strict)

    def __get_pydantic_json_schema__(self, _schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """A schema of all the kinds."""
        return handler(self._union().core_schema)

    def _validate(self, strict: bool, value: Any, info: core_schema.ValidationInfo) -> K:
        # parsed JSON has lists where settings have tuples
        return self._union().validate_python(value, strict=strict and info.mode == "python")

    def _union(self) -> TypeAdapter[K]:
        kinds = self.kinds()
        if self._adapter is None:
            members: Any = Union[tuple(kinds.values())]  # noqa: UP007 - its members are known at run time only
            self._adapter = TypeAdapter(Annotated[members, Field(discriminator="kind")])
        return self._adapter


_REGISTRIES: list[Registry[Any]] = []


def annotation_of(field: FieldInfo) -> Any:
    """The annotation of a field with the registry of its kinds, which pydantic keeps aside."""
    registry = next((item for item in field.metadata if isinstance(item, Registry)), None)
    return field.annotation if registry is None else Annotated[field.annotation, registry]


def register(kind: T) -> T:
    """Class decorator of a plug-in: add a kind to one of its extension points, such as policies (docs/plugins.md).

    Raises PluginError if it has another base class, has no name, or another kind has the same name.

    >>> from typing import Literal
    >>> @fp.register
    ... class FirstSettings(fp.PolicySettings):
    ...     kind: Literal["first"]
    ...     def build(self):
    ...         return fp.policy("greedy").build()
    >>> fp.policy("first").kind
    'first'
    """
    registry_of_kind = next((registry for registry in _REGISTRIES if issubclass(kind, registry.base)), None)
    if registry_of_kind is None:
        bases = ", ".join(registry.base.__name__ for registry in _REGISTRIES)
        raise PluginError(f"{origin_of(kind)}: {kind.__name__} must be derived from one of {bases}.")
    registry_of_kind.add(kind)
    return kind


def load_plugin(file: Path | str) -> ModuleType:
    """Load a file as a plug-in, so that experiments can name what it registers. Loading it again uses its current text.

    Raises PluginError if it cannot be loaded.

    >>> _ = fp.load_plugin(examples / "own_policy.py")
    >>> fp.policy({"kind": "stubborn", "cycles": 3}).cycles
    3
    """
    path = Path(file)
    try:
        return run_plugin(path.stem, path.read_bytes(), str(path.resolve()))
    except OSError as error:
        raise PluginError(f"--plugin {path}: cannot be read ({error.strerror}).") from error


def run_plugin(name: str, source: bytes, path: str) -> ModuleType:
    """Load a plug-in by name (letters, digits and _) from its source; messages call it `path`.

    Raises PluginError.
    """
    if not name.isidentifier():
        raise PluginError(f"--plugin {path}: the file's name must be letters, digits and _, as for any Python module.")
    full_name = MODULE_PREFIX + name
    known = _SOURCES.get(full_name)
    if known is not None and known[1] != path:
        raise PluginError(f"--plugin {path}: another plug-in has the same name, {known[1]}. Rename one of them.")
    spec = importlib.util.spec_from_loader(full_name, loader=None, origin=path)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    module.__file__ = path
    sys.modules[full_name] = module
    _SOURCES[full_name] = (source, path)
    try:
        exec(compile(source, path, "exec"), module.__dict__)
    except PluginError:
        raise
    except Exception as error:
        raise PluginError(f"--plugin {path}: {failure_text(error, path)}.") from error
    return module


def loaded_files() -> Sequence[tuple[str, bytes, str]]:
    """Name, source and path of every loaded plug-in file, for `run_plugin` in a worker process."""
    return [(name.removeprefix(MODULE_PREFIX), *source_and_path) for name, source_and_path in _SOURCES.items()]


def load_files(files: Iterable[tuple[str, bytes, str]]) -> None:
    """Load plug-in files in a worker process, unless it has them (see `loaded_files`). Raises PluginError."""
    for name, source, path in files:
        if _SOURCES.get(MODULE_PREFIX + name) != (source, path):
            run_plugin(name, source, path)


# Source and path of the loaded plug-in files, by module name.
_SOURCES: dict[str, tuple[bytes, str]] = {}
# Top-level packages of the installed plug-ins.
_PACKAGES: set[str] = set()


@cache
def load_installed_plugins() -> None:
    """Load the plug-ins of installed packages, once. Raises PluginError."""
    for entry_point in entry_points(group=ENTRY_POINTS):
        _load_entry_point(entry_point)


def _load_entry_point(entry_point: EntryPoint) -> None:
    _PACKAGES.add(entry_point.module.partition(".")[0])
    try:
        entry_point.load()
    except PluginError:
        raise
    except Exception as error:
        package = entry_point.dist.name if entry_point.dist else "unknown"
        raise PluginError(
            f"the plug-in {entry_point.name!r} of the installed package {package}: {type(error).__name__}: {error}. "
            f"Fix or uninstall it."
        ) from error


def plugin_sources(*kinds: type) -> dict[str, str]:
    """SHA-256 in hex, by module, of the sources of kinds that come from plug-ins.

    It covers the file of a plug-in file, and all Python files of an installed package. Raises PluginError for a kind
    that is in no file, such as one of a notebook's cell: what it uses may be in other cells.
    """
    tops = {kind.__module__.partition(".")[0]: kind.__name__ for kind in kinds}
    return {OF_PLUGINS + top: _digest_of_module(top, name) for top, name in tops.items() if top != PACKAGE.name}


def named_in_plugin(module: str, name: str) -> Any:
    """What a plug-in file, by its stem, or a module of an installed plug-in's package calls by this name.

    Raises PluginError if no such plug-in is loaded, or if it has no such name.
    """
    load_installed_plugins()
    top = module.partition(".")[0]
    if MODULE_PREFIX + module in _SOURCES:
        found = sys.modules[MODULE_PREFIX + module]
    elif top in _PACKAGES:
        try:
            found = importlib.import_module(module)
        except Exception as error:
            raise PluginError(
                f"the module {module} of an installed plug-in: {type(error).__name__}: {error}."
            ) from error
    else:
        raise PluginError(f"no plug-in {module} is loaded; name its file: --plugin {module}.py.")
    if not hasattr(found, name):
        raise PluginError(f"the plug-in {module} has no {name!r}.")
    return getattr(found, name)


def source_of_plugin(module: str) -> dict[str, str]:
    """As `plugin_sources`, for the plug-in that `named_in_plugin` would look into."""
    top = MODULE_PREFIX + module if MODULE_PREFIX + module in _SOURCES else module.partition(".")[0]
    return {OF_PLUGINS + top: _digest_of_module(top, module)}


def _digest_of_module(top: str, name: str) -> str:
    if top in _SOURCES:
        return hashlib.sha256(_SOURCES[top][0]).hexdigest()
    file = getattr(sys.modules.get(top), "__file__", None)
    if file is None:
        raise PluginError(
            f"{name}: what decides stored results has to be in a file. In a notebook, begin its cell with "
            '`%%writefile my_kinds.py`, run it, and load the file with `fp.load_plugin("my_kinds.py")`.'
        )
    path = Path(file)
    return digest_of_files(path.parent.rglob("*.py") if path.name == "__init__.py" else [path])


def origin_of(thing: type | Callable[..., Any]) -> str:
    """Where a class or function of a plug-in was defined: the plug-in's file, else its name with its module."""
    known = _SOURCES.get(thing.__module__)
    return known[1] if known else f"{thing.__module__}.{thing.__qualname__}"


def fault_of_plugin(error: Exception) -> PluginError | None:
    """The same error as the user's, with file and line, if it was raised by a plug-in or by what a plug-in called."""
    place, traceback = "", error.__traceback__
    while traceback is not None:
        frame = traceback.tb_frame
        top = str(frame.f_globals.get("__name__")).partition(".")[0]
        if top in _SOURCES or top in _PACKAGES:
            place = f"{frame.f_code.co_filename}: line {traceback.tb_lineno}"
        traceback = traceback.tb_next
    return PluginError(f"the plug-in {place}: {type(error).__name__}: {error}.") if place else None


def failure_text(error: Exception, path: str) -> str:
    """An error raised by a plug-in, in words, with the line of its file where it was raised."""
    line = error.lineno if isinstance(error, SyntaxError) else None
    traceback = error.__traceback__
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == path:
            line = traceback.tb_lineno
        traceback = traceback.tb_next
    where = f"line {line}: " if line else ""
    message = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{where}{type(error).__name__}: {message}"
