/** Names of what the page has. */

export const KINDS = ["beam", "bar", "rigid", "spring", "joint", "hinge"];
export const MARKS = ["supports", "masses", "loads", "dofs", "names", "ghost"];
export const byId = (id) => document.getElementById(id);
