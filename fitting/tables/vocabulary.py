"""Words of a table's header in the languages of its writers, folded to plain letters, and what they mean."""

import re
import unicodedata

_SIGNS = str.maketrans({
    "µ": "u", "μ": "u", "σ": " sigma ", "±": " sd ", "Δ": " sd ", "δ": " sd ", "²": " squared ", "№": " number ",
    "∅": " diameter ", "Ø": " diameter ", "ø": " diameter ", "⌀": " diameter ", "ł": "l", "Ł": "l", "ı": "i",
})  # fmt: skip
# Each meaning with the words that have it, in plain letters: accents are taken away before words are looked up.
_WORDS = {
    "order": "ordnung ordnungszahl ringordnung ordre rang orden ordine ordem порядок rzad rad orde ordning",
    "number": "nummer ringnummer lfd numero nombre номер numer cislo nomor numara broj n° nº n.o kolejny",
    "ring": "anneau anneaux anillo anillos anello anelli anel кольцо кольца кольце колец кільця кільце prazka prazek "
    "pierscien pierscienia krouzek halka ringe ringes rings krouzku",
    "fringe": "fringes streifen interferenzstreifen frange franges frangia frangie franja franjas полоса полосы полос",
    "dark": "dunkel dunkle dunkler sombre oscuro oscuri scuro escuro темное темного темных ciemny ciemnego",
    "bright": "hell helle heller brillant clair brillante chiaro claro светлое светлого светлых jasny jasnego",
    "diameter": "durchmesser ringdurchmesser diametre diametro диаметр діаметр srednica srednicy diam dia cap diametr "
    "diametern diameters diametres diametros diametri",
    "radius": "halbmesser ringradius rayon raggio radio raio радиус радіус promien promienia straal radie yaricap "
    "polomer radii rayons radios raggi",
    "left": "links linke linker linkes gauche izquierda izq izquierdo sinistra sinistro esquerda слева левый левая "
    "левое левого лев lewa lewy lewo vanster lft lhs vlevo leva",
    "right": "rechts rechte rechter rechtes droite derecha der derecho destra destro direita справа правый правая "
    "правое правого прав prawa prawy prawo hoger rgt rhs vpravo prava",
    "position": "lage ort координата положение posizione posicion pozycja posicao location coordinate "
    "koordinate abscisse",
    "series": "messung messreihe serie series серия опыт seria серii",
    "sd": "fehler unsicherheit messunsicherheit standardabweichung incertitude ecart erreur incertidumbre incerteza "
    "errore incertezza erro погрешность ошибка niepewnosc fout onzekerheid uncert errors deltad",
    "mean": "mittelwert mittel mittlerer mittlere moyenne moyen average avg media medio promedio среднее средний "
    "средняя srednia gemiddelde medelvarde prumer ave",
    "squared": "quadrat carre cuadrado quadrato quadrado квадрат kwadrat square sq sqr carres",
    "reading": "ablesung lecture lectura lettura leitura отсчет показание odczyt aflezing",
    "edge": "rand bord borde bordo край tangente kante brzeg",
    "of": "de des der von di do da dei delle del du d'",
    "the": "le la les el los il lo das die i-ten",
    "mm": "мм", "cm": "см", "um": "мкм mkm", "m": "м", "px": "пкс пикс pixel pixels pxl pix",
    "divisions": "div divs division divisions skt skalenteile skalenteil teilstriche дел деления делений деление ticks",
    "main": "msr hauptskala", "vernier": "vsr vsd vsc csr nonius vernierscale нониус vern vc hsr",
}  # fmt: skip
# In Chinese and Japanese as parts of a text without blanks.
_PARTS = {
    "标准不确定度": "sd", "不确定度": "sd", "标准差": "sd", "误差": "sd", "誤差": "sd", "平均值": "mean",
    "平均": "mean", "直径": "diameter", "直徑": "diameter", "半径": "radius", "半徑": "radius", "级次": "order",
    "级数": "order", "級數": "order", "級次": "order", "次数": "order", "环序": "order", "环数": "order",
    "环次": "order", "序数": "order", "序号": "number", "番号": "number", "编号": "number", "平方": "squared",
    "毫米": "mm", "厘米": "cm", "微米": "um", "位置": "position", "读数": "reading", "讀數": "reading",
    "暗环": "ring", "亮环": "ring", "圆环": "ring", "左侧": "left", "右侧": "right", "左边": "left",
    "右边": "right", "左端": "left", "右端": "right", "左": "left", "右": "right", "环": "ring", "環": "ring",
    "输": "ring", "组": "series", "的": "of", "第": "the",
}  # fmt: skip
_MAIN_SCALE = re.compile(r"\bmain\s+scale\b|\bm\.\s?s\.\s?r\.?")
_VERNIER = re.compile(r"\b(?:vernier|circular|head|drum)\s+scale\b|\bv\.\s?s\.\s?r\.?|\bvernier\s+coincidence\b")
_BETWEEN = re.compile(r"[\s_,;:/()\[\]{}<>.|（）、=′'\"-]+")


def folded(text: str) -> str:
    """A text in small plain letters, without accents, and with words for signs."""
    apart = unicodedata.normalize("NFKD", text.translate(_SIGNS).lower())
    return "".join(letter for letter in apart if not unicodedata.combining(letter)).translate(_SIGNS)


_MEANINGS = {folded(word): meaning for meaning, words in _WORDS.items() for word in words.split()}


def words_of(header: str) -> list[str]:
    """A header's words, in lower case and in English, "squared" for signs of it."""
    text = folded(header)
    for part, word in _PARTS.items():
        text = text.replace(part, f" {word} ")
    text = re.sub(r"\^\s*\{?2\}?|\*\*\s*2", " squared ", text)
    text = _VERNIER.sub(" vernier ", _MAIN_SCALE.sub(" main ", text))
    words = [word for word in _BETWEEN.split(text) if word]
    return [_MEANINGS.get(word, word) for word in words]


def count_of_foreign_words(text: str) -> int:
    """How many words of a text, or parts of one, are a table's in letters beyond ASCII."""
    small = text.lower()
    words = [word for word in _BETWEEN.split(small) if not word.isascii()]
    return sum(folded(word) in _MEANINGS for word in words) + sum(small.count(part) for part in _PARTS if len(part) > 1)
