"""Extension points, and the plug-ins that add to them.

An extension point is a `Registry`: kinds of settings by the name that an experiment file gives in `kind`. A plug-in is
a Python module that adds kinds with `register` when it is loaded. It is found through the entry points (group
`fatigue_planner.plugins`) of installed packages, or is a file that the user names (`--plugin`, `load_plugin`). An
experiment file can name a kind, never a plug-in: to open somebody's file runs nobody's code.
"""

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Generic, TypeVar, Union, get_args

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from fatigue_planner.core.errors import PluginError
from fatigue_planner.core.files import PACKAGE
from fatigue_planner.core.settings import Settings

ENTRY_POINTS = "fatigue_planner.plugins"
# How the module of a plug-in file is called in Python: `fatplan_plugin_<stem of the file>`.
MODULE_PREFIX = "fatplan_plugin_"
# How the entry of a plug-in among the sources of a key begins.
OF_PLUGINS = "plug-in "

K = TypeVar("K", bound=Settings)
T = TypeVar("T", bound=type)


class Registry(Generic[K]):
    """The kinds of an extension point by name.

    `Annotated[Base, registry]` is a field that holds one of them: a tagged union that plug-ins can add to.
    """

    def __init__(self, what: str, base: type[K]) -> None:
        self.what, self.base = what, base
        self._kinds: dict[str, type[K]] = {}
        self._adapter: TypeAdapter[K] | None = None
        _REGISTRIES.append(self)

    def add(self, kind: type[K]) -> None:
        """Add a kind. Raises PluginError if it has no name, or that of another one."""
        field = kind.model_fields.get("kind")
        names = get_args(field.annotation) if field else ()
        if len(names) != 1 or not isinstance(names[0], str):
            raise PluginError(f'{_origin(kind)}: {kind.__name__} needs a name: `kind: Literal["..."]`.')
        known = self._kinds.get(names[0])
        if known is not None and _origin(known) != _origin(kind):
            raise PluginError(f"{_origin(kind)}: the {self.what} {names[0]!r} is already defined in {_origin(known)}.")
        self._kinds[names[0]] = kind
        self._adapter = None

    def kinds(self) -> Mapping[str, type[K]]:
        """The kinds by name, those of installed plug-ins included. Raises PluginError."""
        load_installed_plugins()
        return self._kinds

    def __get_pydantic_core_schema__(self, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        """Any of the kinds that are known when a value is validated."""
        return core_schema.with_info_plain_validator_function(self._validate)

    def __get_pydantic_json_schema__(self, _schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """A schema of all the kinds."""
        return handler(self._union().core_schema)

    def _validate(self, value: Any, info: core_schema.ValidationInfo) -> K:
        # parsed JSON has lists where settings have tuples
        return self._union().validate_python(value, strict=info.mode == "python")

    def _union(self) -> TypeAdapter[K]:
        kinds = self.kinds()
        if self._adapter is None:
            members: Any = Union[tuple(kinds.values())]  # noqa: UP007 - its members are known at run time only
            self._adapter = TypeAdapter(Annotated[members, Field(discriminator="kind")])
        return self._adapter


_REGISTRIES: list[Registry[Any]] = []


def register(kind: T) -> T:
    """Class decorator of a plug-in: add a kind of policy, belief or motion task, by what it is derived from.

    Raises PluginError if it is none of these, has no name, or that of another kind.

    >>> from typing import Literal
    >>> @fp.register
    ... class FirstSettings(fp.PolicySettings):
    ...     kind: Literal["first"]
    ...     def build(self):
    ...         return fp.policy("greedy").build()
    >>> fp.policy("first").kind
    'first'
    """
    found = next((registry for registry in _REGISTRIES if issubclass(kind, registry.base)), None)
    if found is None:
        bases = ", ".join(registry.base.__name__ for registry in _REGISTRIES)
        raise PluginError(f"{_origin(kind)}: {kind.__name__} is derived from none of {bases}.")
    found.add(kind)
    return kind


def load_plugin(file: Path | str) -> ModuleType:
    """Load a file as plug-in: what it registers can be named in experiments. Loading it again takes its present text.

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
    """Load a plug-in of a name (letters, digits and _) from its source; `path` is how it is called in messages.

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
        raise PluginError(f"--plugin {path}: {_failure(error, path)}.") from error
    return module


def loaded_files() -> Sequence[tuple[str, bytes, str]]:
    """Name, source and path of every plug-in file that is loaded, for `run_plugin` in a worker."""
    return [(name.removeprefix(MODULE_PREFIX), *found) for name, found in _SOURCES.items()]


def load_files(files: Iterable[tuple[str, bytes, str]]) -> None:
    """Load plug-in files in a worker, unless it has them (see `loaded_files`). Raises PluginError."""
    for name, source, path in files:
        if _SOURCES.get(MODULE_PREFIX + name) != (source, path):
            run_plugin(name, source, path)


# By the module's name: source and path of the plug-in files loaded.
_SOURCES: dict[str, tuple[bytes, str]] = {}


@cache
def load_installed_plugins() -> None:
    """Load the plug-ins of installed packages, once. Raises PluginError."""
    for found in entry_points(group=ENTRY_POINTS):
        _load_entry_point(found)


def _load_entry_point(found: EntryPoint) -> None:
    try:
        found.load()
    except PluginError:
        raise
    except Exception as error:
        package = found.dist.name if found.dist else "unknown"
        raise PluginError(
            f"the plug-in {found.name!r} of the installed package {package}: {type(error).__name__}: {error}. Mend or "
            f"uninstall it."
        ) from error


def plugin_sources(*kinds: type) -> dict[str, str]:
    """SHA-256, in hex, of the sources of what is not this package's own, by module: what a plug-in decides.

    Of a plug-in file, the file; of an installed one, all Python files of its package; of a class that was typed into a
    session, its text. Raises PluginError if there is no text.
    """
    found = {}
    for kind in kinds:
        top = kind.__module__.partition(".")[0]
        if top != PACKAGE.name:
            found[f"{OF_PLUGINS}{top}"] = _digest_of_module(top, kind)
    return found


def _digest_of_module(top: str, kind: type) -> str:
    if top in _SOURCES:
        return hashlib.sha256(_SOURCES[top][0]).hexdigest()
    file = getattr(sys.modules.get(top), "__file__", None)
    if file is None:
        try:
            return hashlib.sha256(inspect.getsource(kind).encode()).hexdigest()
        except (OSError, TypeError) as error:
            raise PluginError(f"{kind.__name__}: its source cannot be read; define it in a file.") from error
    path = Path(file)
    files = sorted(path.parent.rglob("*.py")) if path.name == "__init__.py" else [path]
    digest = hashlib.sha256()
    for source in files:
        digest.update(source.name.encode() + b"\0" + hashlib.sha256(source.read_bytes()).digest())
    return digest.hexdigest()


def _origin(kind: type) -> str:
    known = _SOURCES.get(kind.__module__)
    return known[1] if known else f"{kind.__module__}.{kind.__qualname__}"


def _failure(error: Exception, path: str) -> str:
    """The error in words, with the line of the plug-in where it was raised."""
    line = error.lineno if isinstance(error, SyntaxError) else None
    traceback = error.__traceback__
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == path:
            line = traceback.tb_lineno
        traceback = traceback.tb_next
    where = f"line {line}: " if line else ""
    message = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{where}{type(error).__name__}: {message}"
