// Runs before the first picture, so that a chosen theme does not flash. Everything else is a module.
"use strict";
try {
  const theme = localStorage.getItem("achse.theme");
  if (theme === "light" || theme === "dark") document.documentElement.dataset.theme = theme;
} catch {
  // storage is switched off: the system's theme it is
}
