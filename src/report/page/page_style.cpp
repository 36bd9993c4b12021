#include "report/page/page_style.hpp"

namespace qerr::page {

const std::string_view style_sheet = R"(
:root{--ink:#1b1b1b;--soft:#595959;--paper:#fff;--grid:#dcdcdc;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#a0437c;--c4:#806600}
body{margin:0 auto;max-width:1200px;padding:1rem;color:var(--ink);background:var(--paper);font:16px/1.45 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.15rem;margin:1.6rem 0 .4rem}
.answer{font-size:1.15rem}.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:1rem}
figure{margin:0;max-width:620px;break-inside:avoid}figcaption{font-weight:600}
svg{display:block;width:100%;height:auto;font:11px system-ui,sans-serif;fill:var(--ink)}
text{unicode-bidi:isolate}
.tick{font-size:10px;fill:var(--soft)}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:var(--grid);fill:none;stroke-width:.7}.line{fill:none;stroke-width:1.8}
.limit{stroke:var(--ink);stroke-width:1.4;stroke-dasharray:1 3;fill:none}.error{stroke:var(--ink);fill:none}
.bar{fill:var(--c0)}
.line.s0{stroke:var(--c0)}.line.s1{stroke:var(--c1);stroke-dasharray:7 3}.line.s2{stroke:var(--c2);stroke-dasharray:2 2}
.line.s3{stroke:var(--c3);stroke-dasharray:8 2 2 2}.line.s4{stroke:var(--c4);stroke-dasharray:12 4}
circle.s0{fill:var(--c0)}circle.s1{fill:var(--c1)}circle.s2{fill:var(--c2)}circle.s3{fill:var(--c3)}circle.s4{fill:var(--c4)}
.legend{list-style:none;margin:.2rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1rem;font-size:.85rem}
.key{display:inline-block;width:28px;height:8px;vertical-align:middle}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:.15rem .6rem;border-bottom:1px solid var(--grid);text-align:right}
th,td{overflow-wrap:normal}td{white-space:nowrap}
th:first-child,td:first-child{text-align:left;min-width:11rem;white-space:normal;overflow-wrap:anywhere}
select{font:inherit;max-width:100%;color:inherit;background:var(--paper)}
pre{white-space:pre-wrap;font-size:.85rem}output{display:block;min-height:1.4em;font-size:.85rem;color:var(--soft)}
@media (prefers-color-scheme:dark){:root{--ink:#ececec;--soft:#b5b5b5;--paper:#15171a;--grid:#3a3d42;--c0:#56b4e9;--c1:#f08a3c;--c2:#35c79b;--c3:#dd92bd;--c4:#e0c341}}
@media print{:root{--ink:#000;--soft:#333;--paper:#fff;--grid:#ccc;--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#a0437c;--c4:#806600}
body{font-size:10pt;padding:0}.figures{grid-template-columns:1fr 1fr}output{display:none}.wide{overflow:visible}}
)";

const std::string_view script = R"(
document.querySelectorAll('.choice').forEach(function(box){
var list=box.querySelector('select'),parts=Array.from(box.querySelectorAll('.option'));
if(!list)return;
box.querySelector('label').hidden=false;
function show(){parts.forEach(function(p,i){p.hidden=i!==list.selectedIndex})}
list.addEventListener('change',show);show()});
document.querySelectorAll('figure').forEach(function(f){
var lines=f.querySelectorAll('[data-points]');
if(!lines.length)return;
var says=document.createElement('output');f.appendChild(says);
f.querySelector('svg').addEventListener('pointermove',function(e){
var best=null,near=900;
lines.forEach(function(l){
var map=l.getScreenCTM(),at=l.getAttribute('d').slice(1).split(/[ML]/),data=l.getAttribute('data-points').split(' ');
at.forEach(function(t,i){
var xy=t.split(' '),dx=xy[0]*map.a+map.e-e.clientX,dy=xy[1]*map.d+map.f-e.clientY,d=dx*dx+dy*dy;
if(near>d){near=d;best=l.parentNode.getAttribute('data-series')+': '+data[i].replace(',',', ')+' (SI units)'}})});
says.textContent=best||''})});
)";

}  // namespace qerr::page
