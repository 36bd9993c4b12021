#include "report/page/page.hpp"

namespace qerr::page {

const std::string_view style_sheet = R"(
:root{--ink:#1a1f27;--soft:#566070;--paper:#fff;--card:#f5f7fa;--grid:#dde2e9;--c0:#0072b2;--c1:#c24f00;--c2:#007a59;--c3:#a0437c;--c4:#806600;--bad:#b3261e;--good:#0b6b45;color-scheme:light dark}
body{margin:0 auto;max-width:1280px;padding:1.2rem;color:var(--ink);background:var(--paper);font:16px/1.45 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.7rem;line-height:1.2;margin:.2rem 0 .6rem}h2{font-size:1.15rem;margin:0 0 .6rem;break-after:avoid}h3{font-size:1rem}
.answer{font-size:1.15rem;max-width:60rem;margin:.4rem 0 1rem}
.head{display:flex;flex-wrap:wrap;gap:.4rem 2rem;background:var(--card);border:1px solid var(--grid);border-radius:8px;padding:.7rem 1rem;margin-bottom:1rem;align-items:start}.head>.about{flex:1 1 24rem}.head>div{min-width:0;max-width:100%}
.about{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1rem;margin:.2rem 0;font-size:.9rem}.about dt{color:var(--soft)}.about dd{margin:0;min-width:0}
.verdict{font-weight:600;white-space:nowrap}.verdict.met{color:var(--good)}.verdict.failed{color:var(--bad)}.verdict.open{color:var(--c4)}
.sections{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,480px),1fr));gap:1rem;grid-auto-flow:dense}
section{min-width:0;border:1px solid var(--grid);border-radius:8px;padding:.8rem 1rem}
section:has(.figures,.scene,.head,.cause,th:nth-child(5),li:nth-child(8)){grid-column:1/-1}section p{margin:.3rem 0 .6rem;max-width:60rem}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:1rem}.figures>div{min-width:0}
figure{margin:0;max-width:620px;break-inside:avoid;position:relative}figcaption{font-weight:600;margin-bottom:.2rem}
svg{display:block;width:100%;height:auto;font:11px system-ui,sans-serif;fill:var(--ink)}
text{unicode-bidi:isolate}
.tick{font-size:10px;fill:var(--soft)}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:var(--grid);fill:none;stroke-width:.7}.line{fill:none;stroke-width:1.8}
.limit{stroke:var(--ink);stroke-width:1.4;fill:none}.l0{stroke-dasharray:1 3}.l1{stroke-dasharray:9 3 1 3}.l2{stroke-dasharray:14 4}
.error{stroke:var(--ink);fill:none}
.s0{--c:var(--c0)}.s1{--c:var(--c1)}.s2{--c:var(--c2)}.s3{--c:var(--c3)}.s4{--c:var(--c4)}
.bar{fill:var(--c,var(--c0))}
.dots{fill:none;stroke:var(--c);stroke-width:2.8;stroke-linecap:round;stroke-opacity:.7}
.line,.error.s0,.error.s1,.error.s2,.error.s3,.error.s4{stroke:var(--c)}.band{fill:var(--c);fill-opacity:.22;stroke:var(--c);stroke-width:.5}
.d1{stroke-dasharray:7 3}.d2{stroke-dasharray:2 2}.d3{stroke-dasharray:8 2 2 2}.d4{stroke-dasharray:12 4}
.mark{fill:var(--c);stroke:var(--paper);stroke-width:.8}.mark.m4{fill:none;stroke:var(--c);stroke-width:2}
.cells{image-rendering:pixelated}.edge{fill:none;stroke:var(--soft);stroke-width:.7}
.cursor{fill:none;stroke:var(--ink);stroke-width:1.2}.window{fill:var(--c0);fill-opacity:.12;stroke:var(--c0)}
.legend{list-style:none;margin:.2rem 0;padding:0;display:flex;flex-wrap:wrap;gap:.1rem 1rem;font-size:.85rem}
.legend li{min-width:0}.key{display:inline-block;width:28px;height:12px;vertical-align:middle}
button,select,input{font:inherit;color:inherit}
button{background:var(--paper);border:1px solid var(--soft);border-radius:5px;padding:0 .5rem;min-width:1.8rem;min-height:1.6rem;cursor:pointer}
button:hover{background:var(--grid)}:focus-visible{outline:2px solid var(--c0);outline-offset:2px}
.legend button{border-color:transparent;background:none;padding:0 .2rem;font-size:inherit;text-align:left}.legend button[aria-pressed=false]{text-decoration:line-through;color:var(--soft)}.legend button[aria-pressed=false] svg{opacity:.3}
.tools{display:flex;gap:.3rem;align-items:center;font-size:.85rem}
.option[hidden],[hidden]{display:none}
.choice label{display:inline-block;margin-bottom:.4rem}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:.2rem .6rem;border-bottom:1px solid var(--grid);text-align:right}thead th{color:var(--soft);font-weight:600}
th,td{overflow-wrap:normal}td{white-space:nowrap}
th:first-child,td:first-child{text-align:left;min-width:5rem;white-space:normal;overflow-wrap:anywhere}
.cause{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,340px),1fr));gap:0 1rem}.cause h3{grid-column:1/-1;margin:.3rem 0}.cause ul{margin:0}.figures>.cause:only-child{grid-column:1/-1}
.verdicts th:first-child,.verdicts td:first-child{min-width:0;white-space:nowrap}.verdicts td.where{color:var(--soft);font-size:.8rem;border:0;white-space:normal;padding-top:0;max-width:24rem}.verdicts th:nth-child(2),.verdicts td:nth-child(2){min-width:9rem;text-align:left;white-space:normal;overflow-wrap:anywhere}
.use{background:linear-gradient(var(--c,var(--c0)),var(--c,var(--c0))) no-repeat 0 100%/var(--p) 4px}.over{--c:var(--bad)}
section .head{border:0;padding:0;margin:0;background:none}
.matrix td{background:color-mix(in srgb,var(--c0) var(--p,0%),transparent)}.matrix{font-size:.8rem}.matrix th:first-child{min-width:8rem;font-weight:400}
select{max-width:100%;background:var(--paper);border:1px solid var(--soft);border-radius:5px;padding:.1rem .3rem}
pre{white-space:pre-wrap;font-size:.85rem}output{display:block;min-height:1.4em;flex:1;min-width:0;font-size:.85rem;color:var(--soft)}
details{margin:1rem 0}summary{cursor:pointer}
.scene{display:grid;grid-template-columns:minmax(0,1fr) 17rem;gap:1rem}@media(max-width:56rem){.scene{grid-template-columns:minmax(0,1fr)}}
.scene canvas{display:block;width:100%;height:min(34rem,110vw);border:1px solid var(--grid);border-radius:8px;background:var(--card);cursor:grab;touch-action:pan-y}
.panel{display:flex;flex-direction:column;gap:.5rem;font-size:.9rem;min-width:0}.panel label{display:block}.panel select,.panel input[type=range]{width:100%;box-sizing:border-box;margin:0}
.panel .boxes{display:flex;flex-wrap:wrap;gap:.1rem .8rem}.panel table{font-size:.8rem;width:100%}.panel td,.panel th{padding:.1rem .2rem}.panel th:first-child,.panel td:first-child{min-width:0;overflow-wrap:normal;white-space:nowrap}.panel output{color:var(--ink);min-height:0;flex:none}
@media(max-width:30rem){body{padding:.6rem}.head,section{padding:.6rem .7rem}th,td{padding:.2rem .35rem}.about{grid-template-columns:1fr}.about dd{margin-bottom:.3rem}}
.flat{display:none}
@media (prefers-color-scheme:dark){:root{--ink:#e9ecf1;--soft:#a9b2bf;--paper:#13161b;--card:#1a1e25;--grid:#343a44;--c0:#56b4e9;--c1:#f08a3c;--c2:#35c79b;--c3:#dd92bd;--c4:#e0c341;--bad:#ff8a80;--good:#5fd39c}}
@page{margin:14mm 12mm 16mm;@bottom-right{content:counter(page) " / " counter(pages);font:9pt system-ui,sans-serif}}
@media print{:root{--ink:#000;--soft:#333;--paper:#fff;--card:#fff;--grid:#ccc;--c0:#0072b2;--c1:#c24f00;--c2:#007a59;--c3:#a0437c;--c4:#806600;--bad:#b3261e;--good:#0b6b45}
body{font-size:9pt;padding:0;max-width:none}h1{font-size:15pt}.figures{grid-template-columns:1fr 1fr 1fr;gap:.4rem .8rem}output,.choice label,.tools,.scene,details:not([open]){display:none}.wide{overflow:visible}.flat{display:block}.sections{display:block}section{border:0;padding:.3rem 0}.head{padding:.2rem .6rem;margin:0}
table{font-size:7pt;line-height:1.2}th,td{padding:0 .4rem}
.choice{display:grid;grid-template-columns:repeat(5,1fr);gap:.3rem .8rem}.option,.option[hidden]{display:block;min-width:0;break-inside:avoid}.option:has(.figures,table){grid-column:1/-1}.option[hidden]:has(.figures){display:none}.legend{font-size:6pt;line-height:1.2;gap:0 .5rem}.key{width:20px;height:9px}.answer{font-size:11pt;margin:.2rem 0}figcaption{font-size:8pt}h2{margin:.2rem 0;font-size:11pt}section p{margin:.1rem 0}h2,section>p{break-after:avoid}svg,.bar,.band,.cells,.use{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
)";

}  // namespace qerr::page
