// Fills an element with a drawing (SVG and HTML), and returns {show}, which changes its parts.  The attribute data-part
// names a part.  `act` is called with the value of data-act when the user clicks a part that has this attribute.
window.axistwinParts = (root, art, act) => {
  root.innerHTML = art;
  const parts = {};
  for (const part of root.querySelectorAll("[data-part]")) parts[part.dataset.part] = part;
  const clicked = (event) => {
    const part = event.target.closest("[data-act]");
    if (!part) return;
    event.preventDefault();
    act(part.dataset.act);
  };
  root.addEventListener("click", clicked);
  root.addEventListener("keydown", (event) => {
    // the browser itself makes a click of these keys for a button of HTML, but not for a part of an SVG
    if ((event.key === "Enter" || event.key === " ") && !event.repeat && event.target.closest("g[data-act]")) clicked(event);
  });

  // Applies changes [part, how, value].  `how`: "move" (smooth CSS transform), "jump" (CSS transform at once), "text",
  // ".class" (add or remove the class) or the name of an attribute.
  function show(changes) {
    for (const [name, how, value] of changes) {
      const part = parts[name];
      if (!part) continue;
      if (how === "move" || how === "jump") {
        part.style.transition = how === "jump" ? "none" : "";
        part.style.transform = value;
      } else if (how === "text") part.textContent = value;
      else if (how.startsWith(".")) part.classList.toggle(how.slice(1), value);
      else part.setAttribute(how, value);
    }
  }

  return { show };
};
