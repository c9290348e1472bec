"""Words of a table's header in the languages of its writers, folded to plain letters, and what they mean."""

import re
import unicodedata

_SIGNS = str.maketrans({
    "µ": "u", "μ": "u", "σ": " sigma ", "±": " sd ", "Δ": " sd ", "δ": " sd ", "²": " squared ", "№": " number ",
    "đ": "d", "∅": " diameter ", "Ø": " diameter ", "ø": " diameter ", "⌀": " diameter ", "ł": "l", "Ł": "l", "ı": "i",
})  # fmt: skip
# Each meaning with the words that have it, in plain letters: accents are taken away before words are looked up.
_WORDS = {
    "order": "ordnung ordnungszahl ringordnung ordre rang orden ordine ordem порядок rzad rad orde ordning τάξη "
    "kertaluku kertaluokka rendszam ordin ordinul redni 차수 رتبة المرتبة stopien ред סדר क्रम "
    "jarjestysluku ลำดับ อันดับ مرتبه tertib реті jark eile",
    "number": "nummer ringnummer lfd numero nombre номер numer cislo nomor numara broj n° nº n.o kolejny αριθμός "
    "sorszam sorszama ringnr numar numarul lp 번호 رقم מספר stt αα "
    "пореден numurs numeris شماره ที่",
    "ring": "anneau anneaux anillo anillos anello anelli anel кольцо кольца кольце колец кільця кільце prazka prazek "
    "pierscien pierscienia krouzek halka ringe ringes rings krouzku δακτύλιος δακτυλίου δακτύλιοι rengas renkaan "
    "gyuru gyurus inel inelul inelului prsten pierscieni 고리 링 무늬 الحلقة حلقة טבעת cincin वलय "
    "gredzena ziedo ronga prstena gelang حلقه วงแหวน пръстен пръстена прстен прстена",
    "fringe": "fringes streifen interferenzstreifen frange franges frangia frangie franja franjas полоса полосы "
    "полос",
    "dark": "dunkel dunkle dunkler sombre oscuro oscuri scuro escuro темное темного темных ciemny ciemnego",
    "bright": "hell helle heller brillant clair brillante chiaro claro светлое светлого светлых jasny jasnego",
    "diameter": "durchmesser ringdurchmesser diametre diametro диаметр діаметр srednica srednicy diam dia cap "
    "diametr diametern diameters diametres diametros diametri διάμετρος halkaisija atmero diametru diametrul premer "
    "promjer priemer пречник диаметър 지름 직경 القطر قطر קוטר व्यास diamater diamter dimeter daimeter "
    "diametrs skersmuo labimoot диаметрі เส้นผ่านศูนย์กลาง",
    "radius": "halbmesser ringradius rayon raggio radio raio радиус радіус promien promienia straal radie yaricap "
    "polomer radii rayons radios raggi ακτίνα säde sateen sugar raza polumjer polmer полупречник радијус 반지름 반경 "
    "شعاع רדיוס त्रिज्या jari-jari jari raduis radious "
    "spindulys raadius jejari รัศมี",
    "left": "links linke linker linkes gauche izquierda izq izquierdo sinistra sinistro esquerda слева левый левая "
    "левое левого лев lewa lewy lewo vanster lft lhs vlevo leva αριστερά αριστερή vasen vasemmalla bal balra stanga "
    "stinga venstre lijevo levo xлев xл 왼쪽 좌측 좌 يسار اليسار שמאל kiri trai ляво",
    "right": "rechts rechte rechter rechtes droite derecha der derecho destra destro direita справа правый правая "
    "правое правого прав prawa prawy prawo hoger rgt rhs vpravo prava δεξιά δεξιή oikea oikealla jobb jobbra "
    "dreapta hojre hoyre desno xправ xпр xп 오른쪽 우측 우 يمين اليمين ימין kanan phai дясно",
    "position": "lage ort координата положение posizione posicion pozycja posicao location coordinate koordinate "
    "abscisse θέση asema pozitie 위치 helyzet",
    "series": "messung messreihe serie series серия опыт seria серii",
    "sd": "fehler unsicherheit messunsicherheit standardabweichung incertitude ecart erreur incertidumbre incerteza "
    "errore incertezza erro погрешность ошибка niepewnosc fout onzekerheid uncert errors deltad σφάλμα αβεβαιότητα "
    "virhe epavarmuus hiba eroare 오차 불확도 usikkerhed usikkerhet",
    "mean": "mittelwert mittel mittlerer mittlere moyenne moyen average avg media medio promedio среднее средний "
    "средняя srednia gemiddelde medelvarde prumer ave μέση μέσος keskiarvo atlag medie 평균 gjennomsnitt gennemsnit "
    "rata-rata",
    "squared": "quadrat carre cuadrado quadrato quadrado квадрат kwadrat square sq sqr carres τετράγωνο nelio "
    "negyzet patrat 제곱 kvadrat",
    "reading": "ablesung lecture lectura lettura leitura отсчет показание odczyt aflezing",
    "edge": "rand bord borde bordo край tangente kante brzeg",
    "of": "de des der von di do da dei delle del du d' на",
    "the": "le la les el los il lo das die i-ten",
    "mm": "мм مم ملم มม χιλ मिमी",
    "cm": "см سم ס״מ सेमी",
    "um": "мкм mkm",
    "m": "м",
    "px": "пкс пикс pixel pixels pxl pix",
    "divisions": "div divs division divisions skt skalenteile skalenteil teilstriche дел деления делений деление "
    "ticks",
    "main": "msr hauptskala",
    "vernier": "vsr vsd vsc csr nonius vernierscale нониус vern vc hsr",
}  # fmt: skip
# In Chinese and Japanese as parts of a text without blanks.
_PARTS = {
    "环序数": "order", "条纹序数": "order", "干涉级": "order", "圈数": "order", "环编号": "number", "环号": "number",
    "标准不确定度": "sd", "不确定度": "sd", "标准差": "sd", "误差": "sd", "誤差": "sd", "平均值": "mean",
    "平均": "mean", "直径": "diameter", "直徑": "diameter", "半径": "radius", "半徑": "radius", "级次": "order",
    "级数": "order", "級數": "order", "級次": "order", "次数": "order", "环序": "order", "环数": "order",
    "环次": "order", "序数": "order", "序号": "number", "番号": "number", "编号": "number", "平方": "squared",
    "毫米": "mm", "厘米": "cm", "微米": "um", "位置": "position", "读数": "reading", "讀數": "reading",
    "暗环": "ring", "亮环": "ring", "圆环": "ring", "左侧": "left", "右侧": "right", "左边": "left",
    "右边": "right", "左端": "left", "右端": "right", "左": "left", "右": "right", "环": "ring", "環": "ring",
    "输": "ring", "组": "series", "的": "of", "の": "of", "第": "the",
}  # fmt: skip
_SIZES = {"diameter", "radius", "left", "right", "position"}
_MAIN_SCALE = re.compile(r"\bmain\s+scale\b|\bm\.\s?s\.\s?r\.?")
_VERNIER = re.compile(r"\b(?:vernier|circular|head|drum)\s+scale\b|\bv\.\s?s\.\s?r\.?|\bvernier\s+coincidence\b")
_BETWEEN = re.compile(r"[\s_,;:/()\[\]{}<>.|（）、=′'\"$\\-]+")
# Meanings of two words: half the diameter in Arabic, and in Vietnamese.
_PHRASES = {"نصف القطر": "radius", "نصف قطر": "radius", "duong kinh": "diameter", "ban kinh": "radius",
            "bac van": "order", "garis pusat": "diameter", 'מ"מ': "mm", "מ״מ": "mm", "п/п": "number"}  # fmt: skip
# In Czech the diameter and the mean.
_DIAMETER_OR_MEAN = "prumer"


# A micro sign in LaTeX; a letter of Danish words that stands for a diameter by itself.
_MICRO, _O_IN_A_WORD = re.compile(r"\$?\\mu\$?\s*"), re.compile(r"(?<=[^\W\d_])[øØ]|[øØ](?=[^\W\d_])")
# A Greek letter by itself is a sign, among others a letter of a word.
_GREEK_WORD = re.compile(r"([\u0370-\u03ff\u1f00-\u1fff]{2,})")


def folded(text: str) -> str:
    """A text in small plain letters, without accents, and with words for signs."""
    parts = _GREEK_WORD.split(_O_IN_A_WORD.sub("o", _MICRO.sub("u", text)))
    return "".join(_plain(part, {} if k % 2 else _SIGNS) for k, part in enumerate(parts))


def _plain(text: str, signs: dict) -> str:
    apart = unicodedata.normalize("NFKD", text.translate(signs).lower())
    return "".join(letter for letter in apart if not unicodedata.combining(letter)).translate(signs)


_MEANINGS = {folded(word): meaning for meaning, words in _WORDS.items() for word in words.split()}


def words_of(header: str) -> list[str]:
    """A header's words, in lower case and in English, "squared" for signs of it."""
    text = folded(header)
    for part, word in _PARTS.items():
        text = text.replace(part, f" {word} ")
    text = re.sub(r"\^\s*\{?2\}?|\*\*\s*2", " squared ", text)
    for phrase, word in _PHRASES.items():
        text = text.replace(folded(phrase), f" {word} ")
    text = _VERNIER.sub(" vernier ", _MAIN_SCALE.sub(" main ", text))
    words = [word for word in _BETWEEN.split(text) if word]
    meanings = [_MEANINGS.get(word, word) for word in words]
    if _DIAMETER_OR_MEAN in words and not _SIZES & set(meanings):
        meanings[words.index(_DIAMETER_OR_MEAN)] = "diameter"
    # A unit of the scale's own, as in "divisions left", stands first.
    return [*meanings[1:], meanings[0]] if meanings[:1] == ["divisions"] else meanings


def count_of_foreign_words(text: str) -> int:
    """How many words of a text, or parts of one, are a table's in letters beyond ASCII."""
    small = text.lower()
    words = [word for word in _BETWEEN.split(small) if not word.isascii()]
    return sum(folded(word) in _MEANINGS for word in words) + sum(small.count(part) for part in _PARTS if len(part) > 1)
