// The lines of a behaviour tree: which are shown, and which are folded.

/** @typedef {{name: string, status: string, message: string, children?: Branch[]}} Branch */
/** @typedef {{path: string, parent: string, level: number, place: number, among: number,
 *   branch: Branch, isOpen: boolean|null}} Line isOpen: null has no children */

/** Where nothing happens it is folded, unless somebody opened it; a condition that fails is ordinary. */
const isOpenAtFirst = (branch) => branch.status === 'running';

/**
 * The lines that are shown, from the root downwards.
 * @param {Branch} root
 * @param {Map<string, boolean>} chosen what somebody opened or folded, by path
 * @returns {Line[]}
 */
export function linesOf(root, chosen) {
  const found = [];
  add(found, root, { parent: '', path: 'root', level: 1, place: 1, among: 1 }, chosen);
  return found;
}

function add(found, branch, where, chosen) {
  const children = branch.children ?? [];
  const isOpen = children.length ? (chosen.get(where.path) ?? isOpenAtFirst(branch)) : null;
  found.push({ ...where, branch, isOpen });
  if (!isOpen) return;
  children.forEach((child, index) => {
    // two children may have one name: their place tells them apart
    const path = `${where.path}/${index}:${child.name}`;
    const place = { parent: where.path, path, level: where.level + 1 };
    add(found, child, { ...place, place: index + 1, among: children.length }, chosen);
  });
}

/** How many behaviours there are. */
export function count(branch) {
  return 1 + (branch.children ?? []).reduce((sum, child) => sum + count(child), 0);
}

/** The paths of all branches that have children: to open or fold the whole tree. */
export function pathsOf(branch, path = 'root') {
  const children = branch.children ?? [];
  const below = children.flatMap((child, index) =>
    pathsOf(child, `${path}/${index}:${child.name}`),
  );
  return children.length ? [path, ...below] : below;
}
