"""Beside a real cobot: a shift cycle by cycle, its belief, its decisions and its journal."""
