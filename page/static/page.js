// Files dropped anywhere on the page go up one by one, then are sorted into recordings together.
window.tr = (sentence, ...values) => (window.sentences[sentence] || sentence).replaceAll('{}', () => values.shift());
(() => {
  const body = document.documentElement;
  body.dataset.drop = tr('Let go to add these files');
  const files = async entry => {
    if (entry.isFile) return new Promise((yes, no) => entry.file(f => yes([[entry.fullPath.replace(/^\//, ''), f]]), no));
    const reader = entry.createReader(), inside = [];
    for (;;) {
      const some = await new Promise((yes, no) => reader.readEntries(yes, no));
      if (!some.length) break;
      for (const one of some) if (!one.name.startsWith('.')) inside.push(...await files(one));
    }
    return inside;
  };
  const say = text => { const place = document.querySelector('#upload-progress'); if (place) place.textContent = text; };
  const upload = async found => {
    const bench = document.querySelector('[data-bench]')?.dataset.bench;
    if (!bench || !found.length) return;
    const batch = crypto.randomUUID(), refused = [];
    for (const [i, [name, file]] of found.entries()) {
      say(tr('Copying {} of {}: {}', i + 1, found.length, name));
      try {
        const answer = await fetch(`/upload/${batch}?name=${encodeURIComponent(name)}`, {method: 'PUT', body: file});
        if (!answer.ok) refused.push(await answer.text());
      } catch (error) { refused.push(tr('{}: the copy was interrupted ({})', name, error.message)); }
    }
    say(tr('Sorting …'));
    const answer = await fetch(`/sort/${batch}?bench=${encodeURIComponent(bench)}`, {method: 'POST'});
    const told = answer.ok ? await answer.json() : {refused: [await answer.text()], open: null};
    refused.push(...told.refused);
    if (refused.length) sessionStorage.setItem('refused', JSON.stringify(refused));
    if (told.open) location.href = told.open; else location.reload();
  };
  window.uploadFiles = input => upload([...input.files].map(f => [f.webkitRelativePath || f.name, f]));
  addEventListener('dragover', e => { if (e.dataTransfer.types.includes('Files')) { e.preventDefault(); body.classList.add('dropping'); } });
  addEventListener('dragleave', e => { if (!e.relatedTarget) body.classList.remove('dropping'); });
  addEventListener('drop', async e => {
    if (!e.dataTransfer.types.includes('Files')) return;
    e.preventDefault(); body.classList.remove('dropping');
    const entries = [...e.dataTransfer.items].map(i => i.webkitGetAsEntry()).filter(Boolean);
    if (!entries.length) return upload([...e.dataTransfer.files].map(f => [f.name, f]));  // dragged out of another program, not from a folder
    upload((await Promise.all(entries.map(files))).flat());
  });
  addEventListener('keydown', e => {  // Space opens a card as Enter does; Ctrl+Z and Ctrl+Shift+Z press Undo and Redo, but not while somebody types
    const on = e.target;
    if (e.key === ' ' && on.matches?.('a.card-link')) { e.preventDefault(); on.click(); }
    if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === 'z' && !on.matches?.('input:not([type=range]), textarea')) {
      const button = document.querySelector(`[data-key=${e.shiftKey ? 'redo' : 'undo'}]`);
      if (button) { e.preventDefault(); button.click(); }
    }
  });
  addEventListener('DOMContentLoaded', () => {
    const refused = JSON.parse(sessionStorage.getItem('refused') || '[]');
    sessionStorage.removeItem('refused');
    const place = document.createElement('div');
    place.id = 'refused';
    place.setAttribute('role', 'alert');
    for (const text of refused) { const line = document.createElement('p'); line.textContent = text; place.append(line); }
    if (refused.length) { place.style = 'position:fixed;bottom:1rem;left:1rem;right:1rem;background:#7a1f1f;color:#fff;padding:.6rem 1rem;z-index:9998;max-height:40vh;overflow:auto'; place.onclick = () => place.remove(); document.body.append(place); }
  });
})();
