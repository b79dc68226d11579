'use strict';
// What a term means, shown while the pointer or the focus is on it.
(function explainTerms() {
  const box = document.getElementById('word');
  let shown = null;

  function hide() {
    if (shown) shown.removeAttribute('aria-describedby');
    shown = null;
    box.hidden = true;
  }

  function show(term) {
    if (term === shown) return;
    hide();
    const { word, trap, source, key } = term.dataset;
    const lines = [['', word], ['trap', trap && 'Mind: ' + trap], ['source', source && 'Source: ' + source],
      ['source', key && 'In report.json: ' + key]];
    box.replaceChildren(...lines.filter(([, text]) => text).map(([kind, text]) => {
      const line = document.createElement('p');
      line.className = kind;
      line.textContent = text;
      return line;
    }));
    if (!box.childElementCount) return;
    box.hidden = false;
    shown = term;
    term.setAttribute('aria-describedby', 'word');

    // Below the term, and within the window.
    const at = term.getBoundingClientRect();
    const left = Math.min(at.left, document.documentElement.clientWidth - box.offsetWidth - 8);
    const below = at.bottom + box.offsetHeight + 8 < window.innerHeight;
    const top = below ? at.bottom + 6 : at.top - box.offsetHeight - 6;
    box.style.left = Math.max(8, left) + window.scrollX + 'px';
    box.style.top = top + window.scrollY + 'px';
  }

  const termOf = (target) => target instanceof Element && target.closest('[data-word]');
  document.addEventListener('pointerover', (event) => {
    const term = termOf(event.target);
    if (term) show(term); else if (!termOf(document.activeElement)) hide();
  });
  document.addEventListener('focusin', (event) => { const term = termOf(event.target); if (term) show(term); else hide(); });
  document.addEventListener('focusout', hide);
  document.addEventListener('keydown', (event) => { if (event.key === 'Escape') hide(); });
})();
