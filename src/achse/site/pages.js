// Beside the theme: tables that scroll get the keyboard's focus, the version's button its own name.
const mend = () => {
  for (const table of document.querySelectorAll(".md-typeset__scrollwrap:not([tabindex])")) {
    Object.assign(table, { tabIndex: 0, role: "region", ariaLabel: "Table" });
  }
  document.querySelector(".md-version__current[aria-label]")?.removeAttribute("aria-label");
};
new MutationObserver(mend).observe(document.body, { childList: true, subtree: true });
mend();
