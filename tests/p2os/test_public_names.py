import p2os


def test_all_lists_what_the_package_imports() -> None:
    modules = {name for name in vars(p2os) if getattr(p2os, name).__class__.__name__ == "module"}
    public = {name for name in vars(p2os) if not name.startswith("_")} - modules
    assert sorted(p2os.__all__) == sorted(public)
