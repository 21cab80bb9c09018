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
 const query=box.value.toLowerCase().trim().replace(/\s+/g,' ');
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
