"""Style and script of the audit's page; nothing is loaded from elsewhere."""

from __future__ import annotations

import json

from voronec.report.symbols import LETTERS

__all__ = ["SCRIPT", "STYLE"]

STYLE = """
:root { --ink:#1a1c20; --soft:#5b626c; --line:#dcdfe4; --paper:#fff; --tint:#f5f6f8;
  --misprint:#b3261e; --proved:#17693a; --definition:#43549a; --convention:#8a5a00;
  --undecided:#7a3e9d; --cited:#46606d; --unaudited:#6b6b4f;
  --sans:system-ui,-apple-system,"Segoe UI",sans-serif; }
@media (prefers-color-scheme:dark) { :root { --ink:#e7e9ec; --soft:#a3abb6; --line:#363c45;
  --paper:#15181c; --tint:#1e2228; --misprint:#ff8a80; --proved:#7bd6a0; --definition:#a9b8ee;
  --convention:#eebf6d; --undecided:#d3a5f0; --cited:#a8c0cc; --unaudited:#c6c6a0; } }
* { box-sizing:border-box; }
html { scroll-padding-top:4.5rem; }
body { font:16px/1.55 "STIX Two Text","Latin Modern Roman",Georgia,"Times New Roman",serif;
  color:var(--ink); background:var(--paper); margin:0 auto; max-width:92rem; padding:0 1.4rem 4rem;
  display:grid; grid-template-columns:15.5rem minmax(0,1fr); gap:0 2.6rem; }
main { max-width:72rem; }
aside { position:sticky; top:0; max-height:100vh; overflow-y:auto; align-self:start;
  padding:2.2rem 0 1rem; font:.84rem/1.4 var(--sans); }
aside ol { list-style:none; margin:.4rem 0 1.2rem; padding:0; }
aside li { margin:.42rem 0; display:flex; justify-content:space-between; gap:.6rem; }
aside a { color:var(--ink); text-decoration:none; } aside a:hover { text-decoration:underline; }
aside b { color:var(--soft); font-weight:600; white-space:nowrap; }
aside i { font-style:normal; color:var(--misprint); }
h1 { font-size:1.75rem; line-height:1.25; margin:2.2rem 0 .4rem; font-weight:600; }
h2 { margin:2.8rem 0 .7rem; font-size:1.3rem; font-weight:600; line-height:1.3;
  border-bottom:1px solid var(--line); padding-bottom:.3rem; }
.by { color:var(--soft); margin:0 0 1.2rem; } .lead { max-width:46rem; }
a { color:var(--definition); }
table { border-collapse:collapse; font:.86rem/1.45 var(--sans); margin:.7rem 0; }
th,td { text-align:left; padding:.22rem .9rem .22rem 0; vertical-align:baseline;
  border-bottom:1px solid var(--line); } th { font-weight:600; color:var(--soft); }
td.n { text-align:right; font-variant-numeric:tabular-nums; }
nav { position:sticky; top:0; background:var(--paper); padding:.7rem 0; z-index:2; display:flex;
  gap:.45rem; flex-wrap:wrap; align-items:center; border-bottom:1px solid var(--line);
  margin-top:2.6rem; }
input { font:.95rem var(--sans); padding:.34rem .7rem; border:1px solid var(--line);
  border-radius:.4rem; background:var(--tint); color:inherit; flex:1 1 14rem; }
button { font:.82rem/1.4 var(--sans); border:1px solid var(--line); color:inherit; background:none;
  border-radius:1rem; padding:.16rem .75rem; cursor:pointer; }
button[aria-pressed=true] { background:var(--ink); color:var(--paper); }
#shown { font:.82rem var(--sans); color:var(--soft); min-width:6rem; text-align:right; }
article { border:1px solid var(--line); border-radius:.5rem; margin:.8rem 0; overflow:hidden; }
article > header { display:flex; gap:.8rem; align-items:baseline; padding:.4rem .95rem;
  background:var(--tint); font:.86rem/1.4 var(--sans); }
article > header a { color:inherit; text-decoration:none; font-weight:600; }
article > header .badge { margin-left:auto; }
article:target { outline:2px solid var(--definition); }
.tag { color:var(--soft); }
.badge { font:600 .73rem/1 var(--sans); letter-spacing:.04em; text-transform:uppercase; }
.misprint { color:var(--misprint); } .proved { color:var(--proved); }
.definition { color:var(--definition); } .convention { color:var(--convention); }
.undecided { color:var(--undecided); } .cited { color:var(--cited); }
.unaudited { color:var(--unaudited); }
.refuted { color:var(--misprint); }
.formula { padding:.5rem .95rem .7rem; } .formula + .formula { border-top:1px solid var(--line); }
.pair { display:grid; grid-template-columns:minmax(0,1fr) minmax(0,1fr); gap:0 1.6rem; }
.cell { overflow-x:auto; overflow-y:hidden; min-width:0; padding:.1rem 0; }
.cell > span { display:block; font:.74rem/1.3 var(--sans); color:var(--soft); }
.wide { grid-column:1/-1; }
.none { color:var(--soft); font-style:italic; margin:.3rem 0; font-size:.92rem; }
.claim { margin:.25rem 0 .35rem; }
math { font-family:"Latin Modern Math","STIX Two Math","Cambria Math","TeX Gyre Termes Math",
  "Libertinus Math","DejaVu Math TeX Gyre",math; font-size:1em; }
.cell { font-size:1.06rem; }
math[display=block] { margin:.3rem 0; width:max-content; text-align:left; }
mo.accent { padding-bottom:.12em; }
.struck { color:var(--misprint); background:linear-gradient(to bottom,transparent 47%,
  currentColor 47%,currentColor 54%,transparent 54%),
  color-mix(in srgb,var(--misprint) 13%,transparent); }
.mended { color:var(--proved); background:color-mix(in srgb,var(--proved) 17%,transparent); }
.method { color:var(--soft); font-size:.92rem; margin:.3rem 0 0; } .method > p { margin:.2rem 0; }
td .method { font-size:.86rem; margin:0; }
.numbers { font:.84rem/1.5 ui-monospace,"DejaVu Sans Mono",monospace; margin:.3rem 0 0;
  overflow-wrap:anywhere; } .numbers span { display:inline-block; min-width:11ch; }
details { font-size:.86rem; margin-top:.2rem; } summary { cursor:pointer; color:var(--soft); }
dl { display:grid; grid-template-columns:auto minmax(0,1fr); gap:0 .9rem; margin:.3rem 0;
  font:.8rem/1.5 ui-monospace,"DejaVu Sans Mono",monospace; }
dd { margin:0; overflow-wrap:anywhere; }
#errata-list > li, #conventions-list > li { margin:0 0 1.3rem; padding-left:.3rem; }
.line { display:grid; grid-template-columns:3.9rem minmax(0,1fr); align-items:center; }
.line > span { font-style:italic; color:var(--soft); }
figure { margin:1.6rem 0; text-align:center; } figure img { max-width:100%; }
figcaption { color:var(--soft); }
[hidden] { display:none !important; }
@media (max-width:70rem) { body { display:block; } aside { position:static; max-height:none; } }
@media (max-width:46rem) { .pair { grid-template-columns:minmax(0,1fr); } }
@media print { body { display:block; max-width:none; } nav, aside { display:none; }
  article { break-inside:avoid; } }
"""

_MORE = {"µ": "mu", "∫": "int", "√": "sqrt", "∑": "sum", "weierstrass": "wp", "integral": "int"}


def _spellings() -> dict[str, list[str]]:
    """What a reader may type -> the commands that show it; a variant of a letter is that letter."""
    found: dict[str, list[str]] = {}
    for command, letter in LETTERS.items():
        plain = command.lower().removeprefix("var")
        same = [c for c in (plain, f"var{plain}") if c in LETTERS or c == command.lower()]
        found[letter.lower()] = [f"\\{name}" for name in same]
    return found | {typed: [f"\\{command}"] for typed, command in _MORE.items()}


SCRIPT = (
    f"const spellings={json.dumps(_spellings(), ensure_ascii=False)};"
    + """
const box=document.getElementById('search'), shown=document.getElementById('shown');
const buttons=[...document.querySelectorAll('nav button')];
const records=[...document.querySelectorAll('main article')];
const sections=[...document.querySelectorAll('main section[data-records]')];
const pressed=b=>b.getAttribute('aria-pressed')=='true';
function spelled(word){
 let found=[word];
 for(const [key,commands] of Object.entries(spellings))if(word.includes(key))
  found=found.concat(found.flatMap(w=>commands.map(c=>w.replaceAll(key,()=>c))));
 return found;}
function show(){
 const query=box.value.toLowerCase().trim().replace(/\\s+/g,' ');
 const named=records.some(a=>a.dataset.name==query);
 const words=query.split(' ').filter(Boolean).map(spelled);
 const letter=/^[A-Z]$/.test(box.value.trim())?box.value.trim():'';
 const wanted=kind=>buttons.filter(b=>pressed(b)&&b.dataset[kind]).map(b=>b.dataset[kind]);
 const verdicts=wanted('verdict'), kinds=wanted('kind'); let n=0;
 for(const a of records){
  const ok=(named?a.dataset.name==query
    :letter?[...a.querySelectorAll('mi')].some(m=>m.textContent==letter):words.every(forms=>forms.some(w=>a.dataset.text.includes(w))))
   &&(!verdicts.length||verdicts.includes(a.dataset.verdict))
   &&(!kinds.length||kinds.includes(a.dataset.kind));
  a.hidden=!ok; n+=ok;}
 for(const s of sections)s.hidden=!s.querySelector('article:not([hidden])');
 shown.textContent=n==records.length?n+' records':n+' of '+records.length;}
box.addEventListener('input',show);
for(const b of buttons)b.addEventListener('click',()=>{
 b.setAttribute('aria-pressed',String(!pressed(b)));show();});
function reveal(hash){const a=document.getElementById(decodeURIComponent(hash.slice(1)));
 if(a&&a.hidden){box.value='';buttons.forEach(b=>b.setAttribute('aria-pressed','false'));show();
 a.scrollIntoView();}}
addEventListener('hashchange',()=>reveal(location.hash));
for(const link of document.querySelectorAll('a[href^="#"]'))
 link.addEventListener('click',()=>reveal(link.getAttribute('href')));
show();
"""
)
