; The test program of the MINASEC-U, written from its description.
; T0 and T1 are set to 1 s, the counter to 10.

; X00 starts, Y00 holds itself and lights the run lamp, X01 stops.
  0  LD   X00
  1  OR   Y00
  2  ANDI X01
  3  ST   Y00

; While running, T0 and T1 let T0 flicker: 1 s off, 1 s on.
  4  LD   Y00
  5  ANDI T1
  6  ST   T0
  7  LD   T0
  8  ST   T1

; Each flicker counts up.
  9  ST   C0

; Y01 lights when the count equals the setting.
 10  LD   C0
 11  ST   Y01

; X02 clears the count.
 12  LD   X02
 13  ST   C0CLR
