// Keyboard shortcuts that control virtual time, except while an element that uses the key itself has the focus.
(() => {
  const TYPING = "input, textarea, select, [contenteditable], [role=application], [role=menu], [role=listbox], .stick";
  const PRESSED = "button, a, [role=button], [role=tab], [role=checkbox], [role=switch], [role=radio], [role=slider]";
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || event.defaultPrevented) return;
    if (event.target.closest(TYPING) || (event.key === " " && event.target.closest(PRESSED))) return;
    if (!" ecsm+-?".includes(event.key)) return;
    event.preventDefault();
    emitEvent("driving-key", { key: event.key, shown: document.querySelector(".run")?.dataset.shown });
  });
})();
