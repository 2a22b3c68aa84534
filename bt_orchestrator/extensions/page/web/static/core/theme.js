/** Light or dark, as chosen here, or else as the computer is set. */

export const THEMES = ['auto', 'light', 'dark'];
const REMEMBERED = 'bt_orchestrator.theme';
const computer = matchMedia('(prefers-color-scheme: dark)');

/** The one that was chosen; auto: as the computer is set. */
export function currentTheme() {
  const chosen = localStorage.getItem(REMEMBERED);
  return THEMES.includes(chosen) ? chosen : 'auto';
}

/** Use one from now on, and remember it. */
export function useTheme(theme) {
  localStorage.setItem(REMEMBERED, theme);
  show();
}

/** Begin with the one that was chosen, and follow the computer where none was. */
export function startTheme() {
  computer.addEventListener('change', show);
  show();
}

function show() {
  const chosen = currentTheme();
  const automatic = computer.matches ? 'dark' : 'light';
  document.documentElement.dataset.theme = chosen === 'auto' ? automatic : chosen;
}
